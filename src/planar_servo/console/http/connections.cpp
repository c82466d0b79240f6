#include "planar_servo/console/http/connections.h"

#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <optional>
#include <thread>
#include <utility>

namespace planar {
namespace {

using SteadyTime = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kMostConnections = 256;
/// A client that has sent nothing for so long may be closed for another one.
constexpr milliseconds kMaySay{100};
/// A whole request must arrive, and a reader must take the next bytes, within this time.
constexpr milliseconds kPatience{3000};
/// The end of answering is heeded within this time.
constexpr milliseconds kHeed{20};
constexpr std::size_t kMostBody = 1 << 20;
constexpr char kLoopback[] = "127.0.0.1";

/// What a connection reads and writes, with bounded patience.
class SocketStream final : public httplib::Stream {
 public:
  explicit SocketStream(Connections::Entry& entry) : entry_(entry) {}

  /// Encrypts what is read and written from now on. Returns whether the other side agrees.
  bool encrypt(const Tls& tls) {
    fcntl(entry_.socket, F_SETFL, fcntl(entry_.socket, F_GETFL) | O_NONBLOCK);
    tls_.emplace(tls, entry_.socket);
    return tls_->accept([this](short event) { return waits_for(event, time_left()); }) > 0;
  }

  bool is_readable() const override {
    return begin_ < end_ || (tls_ && tls_->has_more()) || waits_for(POLLIN, milliseconds(0));
  }
  bool is_writable() const override { return waits_for(POLLOUT, kPatience); }

  ssize_t read(char* to, std::size_t size) override {
    if (begin_ == end_) {
      const ssize_t got = receive();
      if (got <= 0) return got;
      begin_ = 0;
      end_ = static_cast<std::size_t>(got);
    }
    const std::size_t n = std::min(size, end_ - begin_);
    std::copy_n(buffer_.data() + begin_, n, to);
    begin_ += n;
    return static_cast<ssize_t>(n);
  }

  ssize_t write(const char* from, std::size_t size) override {
    if (tls_)
      return tls_->write(from, size, [this](short event) { return waits_for(event, kPatience); });
    if (!waits_for(POLLOUT, kPatience)) return -1;
    return send(entry_.socket, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip = kLoopback;
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    get_remote_ip_and_port(ip, port);
  }
  socket_t socket() const override { return entry_.socket; }

  /// Says that all is written, and takes what still comes: a socket that is closed with bytes
  /// unread takes its answer back.
  void finish() {
    if (tls_) tls_->end();
    shutdown(entry_.socket, SHUT_WR);
    const auto until = SteadyTime::now() + kMaySay;
    while (SteadyTime::now() < until && waits_for(POLLIN, kMaySay) &&
           recv(entry_.socket, buffer_.data(), buffer_.size(), 0) > 0) {
    }
  }

 private:
  ssize_t receive() {
    const auto wait = [this](short event) { return waits_for(event, time_left()); };
    if (tls_) return tls_->read(buffer_.data(), buffer_.size(), wait);
    return wait(POLLIN) ? recv(entry_.socket, buffer_.data(), buffer_.size(), 0) : -1;
  }

  milliseconds time_left() const {
    const auto left =
        std::chrono::duration_cast<milliseconds>(begun_ + kPatience - SteadyTime::now());
    return std::max(left, milliseconds(0));
  }

  bool waits_for(short event, milliseconds patience) const {
    pollfd wanted{entry_.socket, event, 0};
    entry_.since = SteadyTime::now().time_since_epoch().count();
    entry_.waits = true;
    const int found = poll(&wanted, 1, static_cast<int>(patience.count()));
    entry_.waits = false;
    return found > 0 && (wanted.revents & (event | POLLHUP)) != 0;
  }

  Connections::Entry& entry_;
  std::optional<TlsSession> tls_;
  SteadyTime::time_point begun_{SteadyTime::now()};
  std::array<char, 4096> buffer_;
  std::size_t begin_{0}, end_{0};
};

}  // namespace

void Connections::enter() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (served_ >= kMostConnections) {
    close_longest_waiting();
    left_.wait_for(lock, milliseconds(5));
  }
  ++served_;
}

void Connections::leave() {
  const std::lock_guard<std::mutex> lock(mutex_);
  --served_;
  left_.notify_all();
}

Connections::Entry& Connections::add(int socket) {
  const std::lock_guard<std::mutex> lock(mutex_);
  entries_.emplace_back();
  entries_.back().socket = socket;
  return entries_.back();
}

void Connections::remove(const Entry& entry) {
  const std::lock_guard<std::mutex> lock(mutex_);
  entries_.remove_if([&](const Entry& other) { return &other == &entry; });
}

void Connections::close_all() {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto begun = SteadyTime::now();
  left_.wait_for(lock, kMaySay, [&] { return served_ == 0; });  // the last answers go out
  while (served_ > 0) {
    const bool patient = SteadyTime::now() - begun < kPatience;
    for (const Entry& entry : entries_)
      if (entry.waits || !patient) shutdown(entry.socket, SHUT_RDWR);
    left_.wait_for(lock, milliseconds(20));
  }
}

void Connections::close_longest_waiting() {
  const auto latest = (SteadyTime::now() - kMaySay).time_since_epoch().count();
  Entry* longest = nullptr;
  for (Entry& entry : entries_)
    if (entry.waits && !entry.closed && entry.since < latest &&
        (longest == nullptr || entry.since < longest->since))
      longest = &entry;
  if (longest == nullptr) return;
  shutdown(longest->socket, SHUT_RDWR);
  longest->closed = true;
}

ConsoleServer::ConsoleServer(const ListeningPort& port, std::shared_ptr<const Tls> tls)
    : port_(port), tls_(std::move(tls)) {
  svr_sock_ = port.socket();  // httplib ends what it is writing once this is invalid
  set_payload_max_length(kMostBody);
}

void ConsoleServer::answer() {
  while (svr_sock_ != INVALID_SOCKET) {
    const int socket = port_.accept(kHeed);
    if (socket < 0) continue;
    connections_.enter();
    std::thread([this, socket] {
      answer_and_close(socket);
      connections_.leave();
    }).detach();
  }
  connections_.close_all();
}

void ConsoleServer::close() {
  svr_sock_ = INVALID_SOCKET;
}

void ConsoleServer::answer_and_close(int socket) {
  const int yes = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  Connections::Entry& entry = connections_.add(socket);
  SocketStream stream(entry);
  constexpr bool kCloseAfterwards = true;
  bool closed = false;
  if (!tls_ || stream.encrypt(*tls_)) process_request(stream, kCloseAfterwards, closed, nullptr);
  stream.finish();
  connections_.remove(entry);
  ::close(socket);
}

}  // namespace planar
