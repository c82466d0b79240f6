#include "planar_servo/console/http/listening_port.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr int kBacklog = 1024;  // httplib asks for 5, beyond which clients try again after a second

void reuse_address(socket_t socket) {
  const int yes = 1;  // without SO_REUSEPORT, by which a second console could share the port
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

}  // namespace

ListeningPort::ListeningPort(const std::string& address, int port) : number_(port) {
  set_socket_options(reuse_address);
  if (port == 0)
    number_ = bind_to_any_port(address);
  else if (!bind_to_port(address, port))
    number_ = -1;
  if (number_ < 0)
    throw InputError({fmt::format("port {} of {} is taken or not allowed", port, address),
                      "end the program that listens there, or name another one with --port"});
  ::listen(svr_sock_, kBacklog);
  // A client may be gone between poll() and accept().
  fcntl(svr_sock_, F_SETFL, fcntl(svr_sock_, F_GETFL) | O_NONBLOCK);
}

ListeningPort::~ListeningPort() {
  ::close(svr_sock_);
}

int ListeningPort::accept(std::chrono::milliseconds patience) const {
  pollfd client{svr_sock_, POLLIN, 0};
  if (poll(&client, 1, static_cast<int>(patience.count())) <= 0) return -1;
  const int socket = ::accept4(svr_sock_, nullptr, nullptr, SOCK_CLOEXEC);
  if (socket < 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // no descriptor is free
  return socket;
}

}  // namespace planar
