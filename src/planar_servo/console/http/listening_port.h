#pragma once

#include <httplib.h>

#include <chrono>
#include <string>

namespace planar {

/// A port at which clients are let in one by one. While nobody lets them in they wait.
class ListeningPort final : private httplib::Server {
 public:
  /// Listens on this port of this computer's `address`, or on a free one for 0. Throws InputError
  /// when the port is taken or not allowed.
  ListeningPort(const std::string& address, int port);
  ~ListeningPort() override;
  ListeningPort(const ListeningPort&) = delete;
  ListeningPort& operator=(const ListeningPort&) = delete;

  int number() const { return number_; }
  int socket() const { return svr_sock_; }
  /// Returns the socket of the next client, or -1 when none comes within this time.
  int accept(std::chrono::milliseconds patience) const;

 private:
  int number_;
};

}  // namespace planar
