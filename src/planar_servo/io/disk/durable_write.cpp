#include "planar_servo/io/disk/durable_write.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace planar {
namespace {

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// A file system that knows no fsync() is used as it is.
bool sync(int file) {
  return fsync(file) == 0 || errno == EINVAL || errno == ENOTSUP;
}

}  // namespace

bool write_and_close(int file, std::string_view text, Durability durability) {
  const bool done = write_all(file, text) && (durability == Durability::kCrash || sync(file));
  return close(file) == 0 && done;
}

bool sync_folder(const std::filesystem::path& folder) {
  const int file = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return errno == EACCES;  // a folder may be closed to readers and open to writers
  const bool done = sync(file);
  close(file);
  return done;
}

}  // namespace planar
