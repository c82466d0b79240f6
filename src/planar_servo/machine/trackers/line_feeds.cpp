#include "planar_servo/machine/trackers/line_feeds.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <tuple>

#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

constexpr std::size_t kRemembered = 256;  // characters, by whose digits a file is known
constexpr int kConnectPatience_ms = 2000;
constexpr int kReceivePoll_ms = 50;
constexpr std::chrono::milliseconds kReconnectPause{200};

/// Returns what became of a connection that was begun; 0 when it stands.
int outcome_of(int socket) {
  pollfd waiting{socket, POLLOUT, 0};
  if (poll(&waiting, 1, kConnectPatience_ms) <= 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

/// Makes a connection whose cable was pulled end after some ten seconds of silence.
void watch(int socket) {
  const auto set = [socket](int level, int option, int value) {
    setsockopt(socket, level, option, &value, sizeof value);
  };
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 4);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
}

}  // namespace

FileFeed::FileFeed(std::filesystem::path path, ReadingStream& stream)
    : path_(std::move(path)), stream_(stream) {
  if (!open())
    throw WorkError({fmt::format("cannot be read ({})", std::strerror(errno)),
                     "start the tracker's program first, or correct tracker.path",
                     "tracker: " + path_.string(), Cause::kDevice});
  read_rest();
  constexpr double kPeriod_s = 0.01;
  follower_.emplace(kPeriod_s, [this] { follow(); });
}

FileFeed::~FileFeed() {
  follower_.reset();
  close();
}

bool FileFeed::open() {
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe would be waited for
  return file_ >= 0;
}

void FileFeed::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

bool FileFeed::has_its_name() const {
  struct stat here {
  }, there{};
  if (file_ < 0 || fstat(file_, &here) != 0 || stat(path_.c_str(), &there) != 0) return false;
  return here.st_ino == there.st_ino && here.st_dev == there.st_dev;
}

bool FileFeed::holds_what_was_read() const {
  if (last_.empty()) return true;
  std::string there(last_.size(), '\0');
  const auto size = static_cast<ssize_t>(there.size());
  return pread(file_, there.data(), there.size(), offset_ - size) == size && there == last_;
}

void FileFeed::read_rest() {
  std::array<char, 65536> block{};
  for (;;) {
    const ssize_t n = pread(file_, block.data(), block.size(), offset_);
    if (n <= 0)
      return stream_.lose(n < 0 ? fmt::format("the file cannot be read: {}", std::strerror(errno))
                                : "");
    offset_ += n;
    last_.append(block.data(), static_cast<std::size_t>(n));
    last_.erase(0, last_.size() - std::min(last_.size(), kRemembered));
    stream_.take({block.data(), static_cast<std::size_t>(n)});
  }
}

void FileFeed::follow() {
  if (!has_its_name()) {
    close();
    if (!open())
      return stream_.lose(fmt::format("the file cannot be opened: {}", std::strerror(errno)));
  }
  if (!holds_what_was_read()) {
    if (!std::exchange(seems_new_, true)) return;
    offset_ = 0;
    last_.clear();
    stream_.begin_anew();
  }
  seems_new_ = false;
  read_rest();
}

std::pair<std::string, std::string> host_and_port(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0) return {};
  std::string host = address.substr(0, colon), port = address.substr(colon + 1);
  const bool is_port =
      !port.empty() && port.size() <= 5 &&
      std::all_of(port.begin(), port.end(), [](unsigned char c) { return std::isdigit(c) != 0; }) &&
      std::stoi(port) >= 1 && std::stoi(port) <= 65535;
  if (!is_port) return {};
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  return {host, port};
}

TcpFeed::TcpFeed(const std::string& address, ReadingStream& stream) : stream_(stream) {
  std::tie(host_, port_) = host_and_port(address);
  const std::string fault = connect();
  if (!fault.empty())
    throw WorkError({fault, "start the tracker's program first, or correct tracker.address",
                     "tracker: " + address, Cause::kDevice});
  receiver_ = std::thread([this] { serve(); });
}

TcpFeed::~TcpFeed() {
  ending_ = true;
  receiver_.join();
  close();
}

std::string TcpFeed::connect() {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host_.c_str(), port_.c_str(), &wanted, &found); error != 0)
    return fmt::format("the host is not found ({})", gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> all(found, &freeaddrinfo);
  int error = 0;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    socket_ = socket(one->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (socket_ < 0) continue;
    error = ::connect(socket_, one->ai_addr, one->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) error = outcome_of(socket_);
    if (error == 0) {
      watch(socket_);
      return "";
    }
    close();
  }
  return fmt::format("nobody answers ({})", std::strerror(error));
}

void TcpFeed::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

/// Receives until the connection ends.
void TcpFeed::receive() {
  std::array<char, 65536> block{};
  while (!ending_) {
    pollfd waiting{socket_, POLLIN, 0};
    if (poll(&waiting, 1, kReceivePoll_ms) <= 0) continue;
    const ssize_t n = recv(socket_, block.data(), block.size(), 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (n <= 0) return;
    stream_.take({block.data(), static_cast<std::size_t>(n)});
  }
}

void TcpFeed::serve() {
  while (!ending_) {
    receive();
    close();
    stream_.lose("the connection has ended");
    while (!ending_) {
      std::this_thread::sleep_for(kReconnectPause);
      const std::string fault = connect();
      if (fault.empty()) {
        stream_.begin_anew();
        break;
      }
      stream_.lose(fault);
    }
  }
}

}  // namespace planar
