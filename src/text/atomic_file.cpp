#include "text/atomic_file.h"

#include <unistd.h>

#include <sstream>
#include <system_error>

#include "core/error.h"

namespace planar {
namespace fs = std::filesystem;

void write_file(const fs::path& path, std::string_view text) {
  const fs::path temporary = path.string() + ".part" + std::to_string(getpid());
  {
    std::ofstream out(temporary, std::ios::binary);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    out.close();
    if (!out) {
      std::error_code ignored;
      fs::remove(temporary, ignored);
      throw WorkError(path.string() +
                      ": cannot be written; make sure that the folder exists, that "
                      "you may write there and that the disk is not full");
    }
  }
  std::error_code error;
  fs::rename(temporary, path, error);
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
  return in;
}

std::string read_file(const fs::path& path) {
  std::ostringstream text;
  text << open_file(path).rdbuf();
  return text.str();
}

void require_folder_for(const fs::path& output) {
  const fs::path folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw InputError(output.string() + ": the folder " + folder.string() +
                     " does not exist; make it first");
}

void require_not_input(const fs::path& output, const fs::path& input) {
  std::error_code error;
  if (fs::exists(output, error) && fs::equivalent(output, input, error))
    throw InputError(output.string() + ": is an input of this program; name another output");
}

}  // namespace planar
