#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <thread>

#include "planar_servo/trackers/stream/reading_stream.h"

namespace planar {

/// Follows a file to which another program appends lines. A file that became shorter, or another
/// file of that name, is read from its beginning.
class FileFeed final : public StreamFeed {
 public:
  /// Reads what the file holds already, then follows it. Throws WorkError when it cannot be read.
  FileFeed(std::filesystem::path path, ReadingStream& stream);
  ~FileFeed() override;

 private:
  bool open();
  void close();
  /// Returns false when the file is another one now.
  bool is_same() const;
  void read_rest();
  void follow();

  std::filesystem::path path_;
  ReadingStream& stream_;
  int file_{-1};
  std::int64_t offset_{0};
  std::atomic<bool> ending_{false};
  std::thread follower_;
};

}  // namespace planar
