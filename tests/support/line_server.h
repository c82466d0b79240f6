#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace planar::test {

/// Serves text on a TCP port of this computer to one client at a time.
class LineServer {
 public:
  LineServer() {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        listen(listener_, 4) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("cannot listen on the loopback");
    port_ = ntohs(address.sin_port);
  }
  ~LineServer() {
    hang_up();
    ::close(listener_);
  }
  LineServer(const LineServer&) = delete;
  LineServer& operator=(const LineServer&) = delete;

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  /// Waits for the next client.
  void accept_one() {
    hang_up();
    client_ = accept(listener_, nullptr, nullptr);
  }
  void send(const std::string& text) const {
    ::send(client_, text.data(), text.size(), MSG_NOSIGNAL);
  }
  void hang_up() {
    if (client_ >= 0) ::close(client_);
    client_ = -1;
  }

 private:
  int listener_{-1};
  int client_{-1};
  int port_{0};
};

}  // namespace planar::test
