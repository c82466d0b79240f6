#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <list>
#include <mutex>
#include <vector>

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
  /// Closes all and waits until all have left.
  void close_all();

 private:
  void close_longest_waiting();

  std::mutex mutex_;
  std::condition_variable left_;
  std::list<Entry> entries_;
  std::size_t served_{0};
};

/// An HTTP server on 127.0.0.1 that answers one request per connection.
class ConsoleServer final : public httplib::Server {
 public:
  ConsoleServer();

  /// Listens on this port, or on a free one for 0, and returns it. Throws InputError when the port
  /// is taken or not allowed.
  int open(int port);
  /// Answers until close() is called from another thread.
  void answer() { listen_after_bind(); }
  /// Ends what is being answered, too.
  void close();

 private:
  bool process_and_close_socket(socket_t socket) override;

  Connections connections_;
};

}  // namespace planar
