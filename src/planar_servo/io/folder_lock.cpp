#include "planar_servo/io/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "planar_servo/core/error.h"

namespace planar {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0)
    throw InputError(folder.string() + ": cannot be opened: " +
                     std::generic_category().message(errno) + "; name a folder that you may read");
  // A file system without locks is used as it is.
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw InputError(folder.string() +
                   ": another program writes there now; wait until it ends or name another folder");
}

FolderLock::~FolderLock() {
  close(descriptor_);
}

}  // namespace planar
