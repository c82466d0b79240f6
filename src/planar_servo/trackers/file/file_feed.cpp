#include "planar_servo/trackers/file/file_feed.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr std::chrono::milliseconds kPoll{10};

}  // namespace

FileFeed::FileFeed(std::filesystem::path path, ReadingStream& stream)
    : path_(std::move(path)), stream_(stream) {
  if (!open())
    throw WorkError(
        fmt::format("tracker: {}: cannot be read ({}); start the tracker's program first, or "
                    "correct tracker.path",
                    path_.string(), std::strerror(errno)));
  read_rest();
  follower_ = std::thread([this] { follow(); });
}

FileFeed::~FileFeed() {
  ending_ = true;
  follower_.join();
  close();
}

bool FileFeed::open() {
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  offset_ = 0;
  return file_ >= 0;
}

void FileFeed::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

bool FileFeed::is_same() const {
  struct stat here {
  }, there{};
  if (file_ < 0 || fstat(file_, &here) != 0 || stat(path_.c_str(), &there) != 0) return false;
  return here.st_ino == there.st_ino && here.st_dev == there.st_dev && here.st_size >= offset_;
}

void FileFeed::read_rest() {
  std::array<char, 65536> block{};
  for (ssize_t n = 1; n > 0 && !ending_;) {
    n = pread(file_, block.data(), block.size(), offset_);
    if (n < 0) stream_.lose(fmt::format("the file cannot be read: {}", std::strerror(errno)));
    if (n <= 0) return;
    offset_ += n;
    stream_.take({block.data(), static_cast<std::size_t>(n)});
  }
}

void FileFeed::follow() {
  for (; !ending_; std::this_thread::sleep_for(kPoll)) {
    if (!is_same()) {
      close();
      if (!open()) {
        stream_.lose(fmt::format("the file cannot be opened: {}", std::strerror(errno)));
        continue;
      }
      stream_.begin_anew();
    }
    read_rest();
  }
}

}  // namespace planar
