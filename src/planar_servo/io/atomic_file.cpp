#include "planar_servo/io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <set>
#include <sstream>
#include <system_error>

#include "planar_servo/core/error.h"
#include "planar_servo/io/format/format_line.h"

namespace planar {
namespace fs = std::filesystem;

namespace {

bool put(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) break;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return close(file) == 0 && text.empty();
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
  return file >= 0 && put(file, text);
}

/// Throws InputError where a file of another kind stands, as when two names were exchanged.
void require_kind(const fs::path& path, std::string_view kind) {
  const std::string present = kind_of_file(path);
  if (present.empty() || present == kind) return;
  throw InputError(
      fmt::format("{}: is a file of planar-servo/{}, which this output would replace; "
                  "name another file, or remove that one",
                  path.string(), present));
}

/// Returns the file to which the links at `path` lead, or `path` itself when there is no such file.
fs::path behind_links(const fs::path& path) {
  std::error_code error;
  const fs::path end = fs::canonical(path, error);
  return error ? path : end;
}

bool is_device_or_pipe(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : ".";
}

}  // namespace

void write_file(const fs::path& path, std::string_view text) {
  const fs::path place = behind_links(path);
  const bool in_place = is_device_or_pipe(place);
  const fs::path temporary =
      in_place ? place : fs::path(place.string() + ".part" + std::to_string(getpid()));
  std::error_code error;
  require_kind(place, kind_of_text(text));
  if (!write_whole(temporary, text, in_place)) {
    if (!in_place) fs::remove(temporary, error);
    throw WorkError(path.string() +
                    ": cannot be written; make sure that the folder exists, that you may write "
                    "there and that the disk is not full");
  }
  if (in_place) return;
  fs::rename(temporary, place, error);
  if (!error) return;
  const std::string reason = error.message();
  fs::remove(temporary, error);
  throw WorkError(path.string() + ": cannot be put in place: " + reason);
}

std::ifstream open_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    throw InputError(path.string() + ": is a folder; a file is needed here");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path.string() + ": cannot be read; check the name and the permissions");
  spdlog::debug(fmt::format("reading {}", path.string()));
  return in;
}

std::string read_file(const fs::path& path) {
  std::ostringstream text;
  text << open_file(path).rdbuf();
  return text.str();
}

void require_not_input(const fs::path& output, const fs::path& input) {
  std::error_code error;
  if (fs::exists(output, error) && fs::equivalent(output, input, error))
    throw InputError(output.string() + ": is an input of this program; name another output");
}

void require_own_names(const std::vector<fs::path>& outputs) {
  std::set<fs::path> files;
  for (const fs::path& output : outputs)
    if (!output.empty() && !files.insert(fs::weakly_canonical(fs::absolute(output))).second)
      throw InputError(output.string() + ": two outputs have this name; give each its own");
}

void require_writable(const fs::path& output) {
  for (const char* handmade : {"cell", "truth", "targets", "plan"})
    if (kind_of_file(output) == handmade) require_kind(output, {});
  const fs::path place = behind_links(output), folder = folder_of(place);
  std::error_code error;
  if (fs::is_directory(place, error))
    throw InputError(output.string() + ": is a folder; name the file to write");
  if (!fs::is_directory(folder, error))
    throw InputError(output.string() + ": cannot be written: there is no folder '" +
                     folder.string() + "'; make it or name another place");
  if (access(is_device_or_pipe(place) ? place.c_str() : folder.c_str(), W_OK) != 0)
    throw InputError(output.string() + ": cannot be written: you may not write in '" +
                     folder.string() + "'; name another place");
}

}  // namespace planar
