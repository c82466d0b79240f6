#include "planar_servo/io/claims.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

/// These locks belong to the opened file and not to the process, so that nobody else who closes the
/// same file in this program gives them back.
int set_lock(int file, std::uint64_t piece, short kind, bool wait) {
  struct flock range {};
  range.l_type = kind;
  range.l_whence = SEEK_SET;
  range.l_start = static_cast<off_t>(piece);
  range.l_len = 1;
  while (fcntl(file, wait ? F_OFD_SETLKW : F_OFD_SETLK, &range) != 0)
    if (errno != EINTR) return errno;
  return 0;
}

}  // namespace

Claim::Claim(Claim&& other) noexcept : file_(other.file_), piece_(other.piece_) {
  other.file_ = -1;
}

Claim::~Claim() {
  if (file_ >= 0) set_lock(file_, piece_, F_UNLCK, false);
}

Claims::Claims(const std::filesystem::path& file)
    : path_(file), file_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (file_ < 0)
    throw InputError(file.string() + ": cannot be opened to read and write: " +
                     std::generic_category().message(errno) + "; name a place where you may write");
}

Claims::~Claims() {
  close(file_);
}

std::optional<Claim> Claims::try_claim(std::uint64_t piece) {
  if (!lock(piece, false)) return std::nullopt;
  return Claim(file_, piece);
}

Claim Claims::claim(std::uint64_t piece) {
  lock(piece, true);
  return {file_, piece};
}

bool Claims::lock(std::uint64_t piece, bool wait) {
  const int fault = set_lock(file_, piece, F_WRLCK, wait);
  if (fault == EAGAIN || fault == EACCES) return false;
  if (fault != 0)
    throw InputError(path_.string() +
                     ": its file system has no locks, by which programs share work (" +
                     std::generic_category().message(fault) + "); name a place on another one");
  return true;
}

}  // namespace planar
