#include "planar_servo/console/http/connections.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

std::string reason() {
  const char* text = ERR_reason_error_string(ERR_get_error());
  ERR_clear_error();
  return text == nullptr ? "unknown" : text;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what, Cause cause) {
  throw InputError({"is no " + what + ": " + reason(),
                    "make a certificate and its key together, in PEM form", file,
                    access(file.c_str(), F_OK) == 0 ? cause : Cause::kMissing});
}

void require_valid_now(const X509& certificate, const std::filesystem::path& file) {
  const bool begun = X509_cmp_current_time(X509_get0_notBefore(&certificate)) < 0;
  const bool over = X509_cmp_current_time(X509_get0_notAfter(&certificate)) < 0;
  if (!begun || over)
    throw InputError(
        {over ? "the certificate is no longer valid" : "the certificate is not valid yet",
         "make a new one, or set the clock", file});
}

constexpr int kBacklog = 1024;  // httplib asks for 5, beyond which clients try again after a second

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

/// What a connection reads and writes, with bounded patience.
class SocketStream final : public httplib::Stream {
 public:
  explicit SocketStream(Connections::Entry& entry) : entry_(entry) {}

  /// Encrypts what is read and written from now on. Returns whether the other side agrees.
  bool encrypt(const Tls& tls) {
    fcntl(entry_.socket, F_SETFL, fcntl(entry_.socket, F_GETFL) | O_NONBLOCK);
    session_.reset(SSL_new(tls.context()));
    if (!session_ || SSL_set_fd(session_.get(), entry_.socket) != 1)
      throw WorkError("OpenSSL gives no session: " + reason(), Cause::kSystem);
    return encrypted([this] { return SSL_accept(session_.get()); }) > 0;
  }

  bool is_readable() const override {
    return begin_ < end_ || (session_ && SSL_pending(session_.get()) > 0) ||
           waits_for(POLLIN, milliseconds(0));
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
    if (session_)
      return encrypted([=] { return SSL_write(session_.get(), from, static_cast<int>(size)); },
                       /*writes=*/true);
    if (!waits_for(POLLOUT, kPatience)) return -1;
    return send(entry_.socket, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip = "127.0.0.1";
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    get_remote_ip_and_port(ip, port);
  }
  socket_t socket() const override { return entry_.socket; }

  /// Says that all is written, and takes what still comes: a socket that is closed with bytes
  /// unread takes its answer back.
  void finish() {
    if (session_) SSL_shutdown(session_.get());
    ERR_clear_error();
    shutdown(entry_.socket, SHUT_WR);
    const auto until = SteadyTime::now() + kMaySay;
    while (SteadyTime::now() < until && waits_for(POLLIN, kMaySay) &&
           recv(entry_.socket, buffer_.data(), buffer_.size(), 0) > 0) {
    }
  }

 private:
  ssize_t receive() {
    if (session_)
      return encrypted([this] {
        return SSL_read(session_.get(), buffer_.data(), static_cast<int>(buffer_.size()));
      });
    if (!waits_for(POLLIN, time_left())) return -1;
    return recv(entry_.socket, buffer_.data(), buffer_.size(), 0);
  }

  /// Repeats a step of the encryption until it is done. Returns -1 where the other side lets it
  /// wait too long or breaks the rules, 0 where that has ended.
  ssize_t encrypted(const std::function<int()>& step, bool writes = false) const {
    while (true) {
      ERR_clear_error();
      const int done = step();
      if (done > 0) return done;
      const int fault = SSL_get_error(session_.get(), done);
      if (fault == SSL_ERROR_ZERO_RETURN) return 0;
      const bool may_wait = fault == SSL_ERROR_WANT_READ || fault == SSL_ERROR_WANT_WRITE;
      const short event = fault == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT;
      if (!may_wait || !waits_for(event, writes ? kPatience : time_left())) return -1;
    }
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
  std::unique_ptr<SSL, void (*)(SSL*)> session_{nullptr, SSL_free};  ///< null in the clear
  SteadyTime::time_point begun_{SteadyTime::now()};
  std::array<char, 4096> buffer_;
  std::size_t begin_{0}, end_{0};
};

}  // namespace

Tls::Tls(const std::filesystem::path& certificate, const std::filesystem::path& key)
    : context_(SSL_CTX_new(TLS_server_method()), SSL_CTX_free) {
  if (!context_) throw WorkError("OpenSSL gives no context: " + reason(), Cause::kSystem);
  SSL_CTX_set_min_proto_version(context_.get(), TLS1_2_VERSION);
  SSL_CTX_set_mode(context_.get(),
                   SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  if (SSL_CTX_use_certificate_chain_file(context_.get(), certificate.c_str()) != 1)
    refuse(certificate, "certificate", Cause::kInvalid);
  if (SSL_CTX_use_PrivateKey_file(context_.get(), key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      SSL_CTX_check_private_key(context_.get()) != 1)
    refuse(key, "key of this certificate", Cause::kForeign);
  require_valid_now(*SSL_CTX_get0_certificate(context_.get()), certificate);
}

bool Tls::is_for(const std::string& host) const {
  X509* certificate = SSL_CTX_get0_certificate(context_.get());
  return X509_check_host(certificate, host.c_str(), host.size(), 0, nullptr) == 1 ||
         X509_check_ip_asc(certificate, host.c_str(), 0) == 1;
}

ListeningPort::ListeningPort(const std::string& address, int port) : number_(port) {
  // Without SO_REUSEPORT, by which a second console could share the port.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  if (port == 0)
    number_ = bind_to_any_port(address);
  else if (!bind_to_port(address, port))
    number_ = -1;
  if (number_ < 0)
    throw InputError({fmt::format("port {} of {} is taken, not allowed or none of this computer's",
                                  port, address),
                      "end the program that listens there, name another one with --port, or an "
                      "address that `ip address` shows with --listen",
                      "", Cause::kSystem});
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

Connections::Entry& Connections::enter(int socket) {
  std::unique_lock<std::mutex> lock(mutex_);
  while (entries_.size() >= kMostConnections) {
    close_longest_waiting();
    left_.wait_for(lock, milliseconds(5));
  }
  Entry& entry = entries_.emplace_back();
  entry.socket = socket;
  return entry;
}

void Connections::leave(const Entry& entry) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ::close(entry.socket);
  entries_.remove_if([&](const Entry& other) { return &other == &entry; });
  left_.notify_all();
}

void Connections::close_all() {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto begun = SteadyTime::now();
  left_.wait_for(lock, kMaySay, [&] { return entries_.empty(); });  // the last answers go out
  while (!entries_.empty()) {
    const bool patient = SteadyTime::now() - begun < kPatience;
    // Whoever is answered waits for a moment, too, until the socket takes the next bytes.
    const auto latest = (SteadyTime::now() - kMaySay).time_since_epoch().count();
    for (const Entry& entry : entries_)
      if ((entry.waits && entry.since < latest) || !patient) shutdown(entry.socket, SHUT_RDWR);
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
    Connections::Entry& entry = connections_.enter(socket);
    std::thread([this, &entry] {
      try {
        answer_one(entry);
      } catch (const std::exception& error) {
        spdlog::warn("a connection ended: {}", error.what());
      }
      connections_.leave(entry);
    }).detach();
  }
  connections_.close_all();
}

void ConsoleServer::close() {
  svr_sock_ = INVALID_SOCKET;
}

void ConsoleServer::answer_one(Connections::Entry& entry) {
  const int yes = 1;
  setsockopt(entry.socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  SocketStream stream(entry);
  bool closed = false;
  if (!tls_ || stream.encrypt(*tls_))
    process_request(stream, /*close_connection=*/true, closed, nullptr);
  stream.finish();
}

}  // namespace planar
