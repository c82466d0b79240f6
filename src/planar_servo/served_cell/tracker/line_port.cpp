#include "planar_servo/served_cell/tracker/line_port.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr int kMostWaiting = 8;

/// Returns whether the whole text was sent at once.
bool sent(int client, const std::string& text) {
  return send(client, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
         static_cast<ssize_t>(text.size());
}

}  // namespace

LinePort::LinePort(const std::string& host, int port, std::string greeting)
    : greeting_(std::move(greeting)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  const bool is_address = inet_pton(AF_INET, host.c_str(), &address.sin_addr) == 1;
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int yes = 1;  // a port that was closed a moment ago can be had again
  setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (is_address && bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
      listen(listener_, kMostWaiting) == 0)
    return;
  const std::string why = is_address ? std::strerror(errno) : "it is no IPv4 address";
  close(listener_);
  throw WorkError(fmt::format("no tracker can be served on {}:{}: {}", host, port, why));
}

LinePort::~LinePort() {
  for (const int client : clients_) close(client);
  close(listener_);
}

void LinePort::accept_waiting() {
  for (;;) {
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) return;
    if (sent(client, greeting_))
      clients_.push_back(client);
    else
      close(client);
  }
}

void LinePort::send(const std::string& text) {
  accept_waiting();
  const auto gone = std::remove_if(clients_.begin(), clients_.end(), [&](int client) {
    if (sent(client, text)) return false;
    close(client);
    return true;
  });
  clients_.erase(gone, clients_.end());
}

}  // namespace planar
