#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>

struct ssl_ctx_st;

namespace planar {

/// TLS for a server, by its certificate and key.
class Tls {
 public:
  /// Throws InputError for files that are not a certificate, valid now, and its key in PEM form.
  Tls(const std::filesystem::path& certificate, const std::filesystem::path& key);

  /// Returns whether the certificate is for this name or address.
  bool is_for(const std::string& host) const;

  ssl_ctx_st* context() const { return context_.get(); }

 private:
  std::shared_ptr<ssl_ctx_st> context_;
};

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

/// The connections of a server, each served by a thread of its own and kept in bounds: where there
/// are as many as may be, the one that has been waited for longest is closed for the next, so that
/// readers that are slow or say nothing keep nobody out.
class Connections {
 public:
  /// One of them. Its thread notes when it begins to wait for the other side.
  struct Entry {
    int socket{-1};
    std::atomic<bool> waits{false};
    std::atomic<std::chrono::steady_clock::rep> since{0};
    bool closed{false};
  };

  /// Waits, not long, until one more may be served, and adds it.
  Entry& enter(int socket);
  /// Closes its socket and forgets it.
  void leave(const Entry& entry);
  /// Closes those that wait for the other side, lets the others be answered for a while, and waits
  /// until all have left.
  void close_all();

 private:
  void close_longest_waiting();

  std::mutex mutex_;
  std::condition_variable left_;
  std::list<Entry> entries_;
};

/// An HTTP server that answers one request per connection.
class ConsoleServer final : public httplib::Server {
 public:
  /// Without `tls` nothing is encrypted. `port` must outlive the server.
  explicit ConsoleServer(const ListeningPort& port, std::shared_ptr<const Tls> tls = nullptr);

  /// Answers the port's clients until another thread calls close(). Later ones wait at the port.
  void answer();
  /// Ends answer(), which runs in another thread or is about to, and what is being answered.
  void close();

 private:
  void answer_one(Connections::Entry& entry);

  const ListeningPort& port_;
  std::shared_ptr<const Tls> tls_;
  Connections connections_;
};

}  // namespace planar
