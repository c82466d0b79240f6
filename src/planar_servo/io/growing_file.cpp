#include "planar_servo/io/growing_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "planar_servo/core/error.h"

namespace planar {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0)
    throw InputError({"cannot be opened: " + std::generic_category().message(errno),
                      "name a folder that you may read", folder});
  // A file system without locks is used as it is.
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw InputError(
      {"another program writes there now", "wait until it ends or name another folder", folder});
}

FolderLock::~FolderLock() {
  close(descriptor_);
}

namespace fs = std::filesystem;

namespace {

bool ends_with_line(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return !in.seekg(-1, std::ios::end) || in.get() == '\n';
}

[[noreturn]] void refuse_table(const fs::path& path) {
  throw InputError({"holds something else already", "move it away, or name another file", path});
}

/// Throws unless the file begins with the header's first line and has its last, the columns.
void require_table(const fs::path& path, const std::string& header) {
  const std::string text = read_file(path);
  const std::size_t columns = header.substr(0, header.size() - 1).rfind('\n') + 1;
  const bool begins_so = text.rfind(header.substr(0, header.find('\n')), 0) == 0;
  if (!begins_so || text.find(header.substr(columns)) == std::string::npos) refuse_table(path);
}

}  // namespace

void require_growable(const fs::path& path) {
  require_no_link(path);
  if (!fs::exists(path)) return require_writable(path, {});
  if (!std::ofstream(path, std::ios::app))
    throw InputError({"cannot be added to", "a file that you may write is needed", path});
}

void drop_torn_line(const fs::path& path, const std::string& header) {
  require_no_link(path);
  if (!fs::is_regular_file(path) || fs::is_empty(path)) return;
  if (!header.empty()) require_table(path, header);
  if (ends_with_line(path)) return;
  const std::size_t end = read_file(path).find_last_of('\n');
  const std::size_t whole = end == std::string::npos ? 0 : end + 1;
  std::error_code error;
  fs::resize_file(path, whole, error);
  if (error)
    throw InputError({"its last line is torn and cannot be cut off: " + error.message(), "", path});
}

void require_header(const fs::path& path, const std::string& header) {
  if (fs::exists(path) && read_file(path).rfind(header, 0) != 0) refuse_table(path);
}

GrowingFile::GrowingFile(fs::path path, const std::string& header) : path_(std::move(path)) {
  require_growable(path_);
  drop_torn_line(path_, header);
  if (!fs::exists(path_) || (fs::is_empty(path_) && !header.empty())) write_file(path_, header);
}

bool holds_no_row(const fs::path& path, const std::string& header) {
  return !fs::exists(path) || read_file(path) == header;
}

void GrowingFile::append(const std::string& lines, Durability durability) {
  const int file = open(path_.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0 || !write_and_close(file, lines, durability))
    throw WorkError({"cannot be written", "is the disk full?", path_});
}

void make_folder(const fs::path& path) {
  std::error_code error;
  const fs::path above = fs::absolute(path).lexically_normal().parent_path();
  if (fs::is_directory(path, error)) return;
  if (!fs::exists(above, error)) make_folder(above);
  if (fs::create_directory(path, error)) sync_folder(above);
  if (error)
    throw InputError(
        {"cannot be made: " + error.message(), "name a folder where you may write", path});
}

}  // namespace planar
