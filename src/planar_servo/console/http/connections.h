#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "planar_servo/console/http/listening_port.h"
#include "planar_servo/console/http/tls.h"

namespace planar {

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

  /// Waits, not long, until one more may be served, and counts it.
  void enter();
  void leave();
  Entry& add(int socket);
  void remove(const Entry& entry);
  /// Closes those that wait for the other side, lets the others be answered for a while, and waits
  /// until all have left.
  void close_all();

 private:
  void close_longest_waiting();

  std::mutex mutex_;
  std::condition_variable left_;
  std::list<Entry> entries_;
  std::size_t served_{0};
};

/// An HTTP server that answers one request per connection.
class ConsoleServer final : public httplib::Server {
 public:
  /// Without `tls` nothing is encrypted. `port` must outlive the server.
  explicit ConsoleServer(const ListeningPort& port, std::shared_ptr<const Tls> tls = nullptr);

  /// Answers the port's clients until close() is called from another thread. Later clients wait at
  /// the port.
  void answer();
  /// Ends answer(), which runs in another thread or is about to, and what is being answered.
  void close();

 private:
  void answer_and_close(int socket);

  const ListeningPort& port_;
  std::shared_ptr<const Tls> tls_;
  Connections connections_;
};

}  // namespace planar
