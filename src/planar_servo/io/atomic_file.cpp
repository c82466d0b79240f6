#include "planar_servo/io/atomic_file.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <sstream>
#include <system_error>

#include "planar_servo/core/error.h"

namespace planar {
namespace fs = std::filesystem;

namespace {

bool put(const fs::path& path, std::string_view text) {
  std::ofstream out(path, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  return static_cast<bool>(out);
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
  if (!put(temporary, text)) {
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

void require_writable(const fs::path& output) {
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
