#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "planar_servo/base/core/threads.h"
#include "planar_servo/machine/trackers/stream_tracker.h"

namespace planar {

/// Follows a file to which another program appends lines. One that was written anew is continued
/// where it still holds what was read, and else read from its beginning.
class FileFeed final : public StreamFeed {
 public:
  /// Reads what the file holds already, then follows it. Throws WorkError when it cannot be read.
  FileFeed(std::filesystem::path path, ReadingStream& stream);
  ~FileFeed() override;

 private:
  bool open();
  void close();
  bool has_its_name() const;
  bool holds_what_was_read() const;
  void read_rest();
  void follow();

  std::filesystem::path path_;
  ReadingStream& stream_;
  int file_{-1};
  std::int64_t offset_{0};
  std::string last_;       ///< the end of what was read, which stands before the offset
  bool seems_new_{false};  ///< or is only half written again
  std::optional<Repeater> follower_;
};

/// Receives lines from a program that serves them on a TCP port. It always takes them, so that
/// nobody has to wait, and connects again when the connection ends.
class TcpFeed final : public StreamFeed {
 public:
  /// Connects to `address`, HOST:PORT. Throws WorkError when nobody answers there.
  TcpFeed(const std::string& address, ReadingStream& stream);
  ~TcpFeed() override;

 private:
  /// Returns why there is no connection; empty when there is one.
  std::string connect();
  void close();
  void receive();
  void serve();

  std::string host_, port_;
  ReadingStream& stream_;
  int socket_{-1};
  std::atomic<bool> ending_{false};
  std::thread receiver_;
};

/// Splits HOST:PORT, as in `tracker.example:7000` and `[::1]:7000`. Both are empty for anything
/// else.
std::pair<std::string, std::string> host_and_port(const std::string& address);

}  // namespace planar
