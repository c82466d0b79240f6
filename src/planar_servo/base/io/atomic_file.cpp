#include "planar_servo/base/io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <initializer_list>
#include <set>
#include <sstream>
#include <system_error>

#include "planar_servo/base/core/error.h"

namespace planar {

namespace fs = std::filesystem;

namespace {

constexpr int kHeadLines = 4;
constexpr int kEndBytes = 4096;
constexpr std::string_view kNumpyBegin = "\x93NUMPY";

/// Takes off the first of these beginnings that the text has. Returns whether it has one.
bool drop_one_of(std::initializer_list<std::string_view> beginnings, std::string_view& text) {
  for (const std::string_view beginning : beginnings) {
    if (text.substr(0, beginning.size()) != beginning) continue;
    text.remove_prefix(beginning.size());
    return true;
  }
  return false;
}

std::string_view kind_of_line(std::string_view line) {
  drop_one_of({"# ", "% ", "<!-- ", "  ", "{"}, line);
  if (!drop_one_of({"format: ", "\"format\": \"", "\"format\":\""}, line) ||
      !drop_one_of({"planar-servo/"}, line))
    return {};
  return line.substr(0, line.find('/'));
}

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

/// Opens a file that is not there yet. What stands there under its name is removed, not followed:
/// it is what a program that crashed left behind, or a link that somebody planted.
int open_new(const fs::path& path) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  constexpr mode_t kMode = 0666;  // less the user's umask
  const int file = open(path.c_str(), kFlags, kMode);
  if (file >= 0 || errno != EEXIST || unlink(path.c_str()) != 0) return file;
  return open(path.c_str(), kFlags, kMode);
}

bool write_whole(const fs::path& path, std::string_view text, bool in_place) {
  const int file = in_place ? open(path.c_str(), O_WRONLY | O_CLOEXEC) : open_new(path);
  return file >= 0 &&
         write_and_close(file, text, in_place ? Durability::kCrash : Durability::kPowerLoss);
}

bool is_device_or_pipe(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : ".";
}

/// Looks at a file's first bytes and its last, where its line of the format may stand.
std::string kind_of_file(const fs::path& path) {
  std::string ends(2 * static_cast<std::size_t>(kEndBytes), '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(ends.data(), kEndBytes);
  std::streamsize size = in.gcount();
  if (size == kEndBytes) {
    in.seekg(-std::min<std::streamoff>(kEndBytes, in.seekg(0, std::ios::end).tellg() - size),
             std::ios::end);
    in.read(ends.data() + size, kEndBytes);
    size += in.gcount();
  }
  ends.resize(static_cast<std::size_t>(size));
  return std::string(kind_of_text(ends));
}

/// Throws InputError where this output would replace what is not ours or of another kind, as when
/// two names were exchanged.
void require_kind(const fs::path& path, std::string_view kind) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) == 0) return;
  const std::string present = kind_of_file(path);
  if (!present.empty() && present == kind) return;
  throw InputError({fmt::format("is {}, which this output would replace",
                                present.empty() ? "a file of another program or of a person"
                                                : "a file of planar-servo/" + present),
                    "name another file, or remove that one", path, Cause::kExists});
}

bool ends_with_line(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return !in.seekg(-1, std::ios::end) || in.get() == '\n';
}

[[noreturn]] void refuse_table(const fs::path& path) {
  throw InputError({"holds something else already",
                    "move it away, or name another file; another version of this program may have "
                    "written it, with other columns",
                    path, Cause::kForeign});
}

/// Throws unless the file begins with the header's first line and has its last, the columns.
void require_table(const fs::path& path, const std::string& header) {
  const std::string text = read_file(path);
  const std::size_t columns = header.substr(0, header.size() - 1).rfind('\n') + 1;
  const bool begins_so = text.rfind(header.substr(0, header.find('\n')), 0) == 0;
  if (!begins_so || text.find(header.substr(columns)) == std::string::npos) refuse_table(path);
}

}  // namespace

std::string_view kind_of_text(std::string_view text) {
  if (text.substr(0, 2) == "P5") return "image";
  if (text.substr(0, kNumpyBegin.size()) == kNumpyBegin)
    text.remove_prefix(std::min(text.find("format: "), text.size()));
  const std::string_view last_line = text.substr(text.rfind('\n', text.size() - 2) + 1);
  for (int i = 0; i < kHeadLines && !text.empty(); ++i) {
    const std::size_t length = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view kind = kind_of_line(text.substr(0, length));
    if (!kind.empty()) return kind;
    text.remove_prefix(length);
  }
  return kind_of_line(last_line);
}

std::string with_format_key(const std::string& kind, const std::string& object) {
  const std::string rest = object.substr(object.find('{') + 1);
  return fmt::format("{{\n  \"format\": \"planar-servo/{}/1\"{}{}\n", kind,
                     rest.find('"') == std::string::npos ? "\n" : ",", rest);
}

std::string format_comment(const std::string& kind) {
  return fmt::format("<!-- format: planar-servo/{}/1 -->\n", kind);
}

std::string format_remark(const std::string& kind) {
  return fmt::format("% format: planar-servo/{}/1\n", kind);
}

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

void require_no_link(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error) || is_device_or_pipe(path)) return;
  throw InputError({"is a link, through which nothing is written",
                    "name the file itself, or remove the link", path});
}

void write_file(const fs::path& path, std::string_view text) {
  require_no_link(path);
  const bool in_place = is_device_or_pipe(path);
  const fs::path temporary =
      in_place ? path : fs::path(path.string() + ".part" + std::to_string(getpid()));
  std::error_code error;
  require_kind(path, kind_of_text(text));
  if (!write_whole(temporary, text, in_place)) {
    if (!in_place) fs::remove(temporary, error);
    throw WorkError(
        {"cannot be written",
         "make sure that the folder exists, that you may write there and that the disk is not full",
         path, Cause::kSystem});
  }
  if (in_place) return;
  fs::rename(temporary, path, error);
  if (!error && sync_folder(folder_of(path))) return;
  if (!error)
    throw WorkError({fmt::format("is written, but the disk does not confirm it: {}",
                                 std::generic_category().message(errno)),
                     "check the disk before you rely on the file", path, Cause::kSystem});
  const std::string reason = error.message();
  fs::remove(temporary, error);
  throw WorkError({"cannot be put in place: " + reason, "", path, Cause::kSystem});
}

std::ifstream open_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    throw InputError({"is a folder", "a file is needed here", path});
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw InputError({"cannot be read", "check the name and the permissions", path,
                      fs::exists(path, error) ? Cause::kSystem : Cause::kMissing});
  spdlog::debug(fmt::format("reading {}", path.string()));
  return in;
}

std::string read_file(const fs::path& path) {
  std::ifstream in = open_file(path);
  std::ostringstream text;
  if (in.peek() != std::ifstream::traits_type::eof()) text << in.rdbuf();
  if (in.bad() || text.fail())
    throw InputError({"cannot be read to its end", "check the disk or network where it lies", path,
                      Cause::kSystem});
  return text.str();
}

void require_not_input(const fs::path& output, const fs::path& input) {
  std::error_code error;
  if (fs::exists(output, error) && fs::equivalent(output, input, error))
    throw InputError(
        {"is an input of this program", "name another output", output, Cause::kExists});
}

void require_outputs(const std::vector<std::pair<fs::path, const char*>>& outputs,
                     const std::vector<fs::path>& inputs) {
  std::set<fs::path> files;
  for (const auto& [output, kind] : outputs)
    if (!output.empty() && !files.insert(fs::weakly_canonical(fs::absolute(output))).second)
      throw InputError({"two outputs have this name", "give each its own", output, Cause::kExists});
  for (const auto& [output, kind] : outputs) {
    if (output.empty()) continue;
    for (const fs::path& input : inputs) require_not_input(output, input);
    require_writable(output, kind);
  }
}

void require_writable(const fs::path& output, std::string_view kind) {
  constexpr std::string_view kHandmade[] = {"cell", "truth", "targets", "plan"};
  const bool is_handmade = std::count(std::begin(kHandmade), std::end(kHandmade), kind) != 0;
  require_no_link(output);
  require_kind(output, is_handmade ? std::string_view() : kind);
  const fs::path folder = folder_of(output);
  std::error_code error;
  if (fs::is_directory(output, error))
    throw InputError({"is a folder", "name the file to write", output});
  if (!fs::is_directory(folder, error))
    throw InputError({"cannot be written: there is no folder '" + folder.string() + "'",
                      "make it or name another place", output, Cause::kMissing});
  if (access(is_device_or_pipe(output) ? output.c_str() : folder.c_str(), W_OK) != 0)
    throw InputError({"cannot be written: you may not write in '" + folder.string() + "'",
                      "name another place", output, Cause::kSystem});
}

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0)
    throw InputError({"cannot be opened: " + std::generic_category().message(errno),
                      "name a folder that you may read", folder, Cause::kSystem});
  // A file system without locks is used as it is.
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw InputError({"another program writes there now", "wait until it ends or name another folder",
                    folder, Cause::kBusy});
}

FolderLock::~FolderLock() {
  close(descriptor_);
}

namespace {

/// Whatever cannot be told is found by opening it.
bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

}  // namespace

void require_growable(const fs::path& path) {
  require_no_link(path);
  if (!is_there(path)) return require_writable(path, {});
  if (!std::ofstream(path, std::ios::app))
    throw InputError(
        {"cannot be added to", "a file that you may write is needed", path, Cause::kSystem});
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
    throw InputError({"its last line is torn and cannot be cut off: " + error.message(), "", path,
                      Cause::kSystem});
}

void require_header(const fs::path& path, const std::string& header) {
  if (is_there(path) && read_file(path).rfind(header, 0) != 0) refuse_table(path);
}

GrowingFile::GrowingFile(fs::path path, const std::string& header) : path_(std::move(path)) {
  require_growable(path_);
  drop_torn_line(path_, header);
  if (!is_there(path_) || (fs::is_empty(path_) && !header.empty())) write_file(path_, header);
}

bool holds_no_row(const fs::path& path, const std::string& header) {
  return !is_there(path) || read_file(path) == header;
}

void GrowingFile::append(const std::string& lines, Durability durability) {
  const int file = open(path_.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0 || !write_and_close(file, lines, durability))
    throw WorkError({"cannot be written", "is the disk full?", path_, Cause::kSystem});
}

void make_folder(const fs::path& path) {
  std::error_code error;
  const fs::path above = fs::absolute(path).lexically_normal().parent_path();
  if (fs::is_directory(path, error)) return;
  if (!fs::exists(above, error)) make_folder(above);
  if (fs::create_directory(path, error)) sync_folder(above);
  if (error)
    throw InputError({"cannot be made: " + error.message(), "name a folder where you may write",
                      path, Cause::kSystem});
}

}  // namespace planar
