#pragma once

#include <string>
#include <vector>

namespace planar {

/// Serves lines on a TCP port of this machine to whoever connects.
class LinePort {
 public:
  /// `host` is an IPv4 address of this machine. `greeting` is what each client is sent first.
  /// Throws WorkError when the port cannot be had.
  LinePort(const std::string& host, int port, std::string greeting);
  ~LinePort();
  LinePort(const LinePort&) = delete;
  LinePort& operator=(const LinePort&) = delete;

  /// Sends text to all clients. Those that do not read or are gone are hung up on.
  void send(const std::string& text);

 private:
  void accept_waiting();

  std::string greeting_;
  int listener_{-1};
  std::vector<int> clients_;
};

}  // namespace planar
