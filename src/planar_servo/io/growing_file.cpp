#include "planar_servo/io/growing_file.h"

#include <fstream>
#include <system_error>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

bool ends_with_line(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return !in.seekg(-1, std::ios::end) || in.get() == '\n';
}

}  // namespace

void require_growable(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return require_writable(path);
  if (!std::ofstream(path, std::ios::app))
    throw InputError(path.string() + ": cannot be added to; a file that you may write is needed");
}

void drop_torn_line(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) return;
  if (ends_with_line(path)) return;
  const std::size_t end = read_file(path).find_last_of('\n');
  const std::size_t whole = end == std::string::npos ? 0 : end + 1;
  std::error_code error;
  std::filesystem::resize_file(path, whole, error);
  if (error)
    throw InputError(path.string() +
                     ": its last line is torn and cannot be cut off: " + error.message());
}

void require_header(const std::filesystem::path& path, const std::string& header) {
  if (!std::filesystem::exists(path) || read_file(path).rfind(header, 0) == 0) return;
  throw InputError(path.string() +
                   ": holds something else already; move it away, or name another file");
}

GrowingFile::GrowingFile(std::filesystem::path path, const std::string& header)
    : path_(std::move(path)) {
  require_growable(path_);
  drop_torn_line(path_);
  if (!std::filesystem::exists(path_) || (std::filesystem::is_empty(path_) && !header.empty()))
    write_file(path_, header);
}

void GrowingFile::append(const std::string& lines) {
  std::ofstream out(path_, std::ios::app | std::ios::binary);
  out << lines << std::flush;
  if (!out) throw WorkError(path_.string() + ": cannot be written; is the disk full?");
}

void GrowingFile::remove() {
  std::error_code error;
  std::filesystem::remove(path_, error);
}

void make_folder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error)
    throw InputError(path.string() + ": cannot be made: " + error.message() +
                     "; name a folder where you may write");
}

}  // namespace planar
