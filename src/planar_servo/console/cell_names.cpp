#include "planar_servo/console/cell_names.h"

#include <cctype>
#include <nlohmann/json.hpp>

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Returns whether a path may begin behind this letter.
bool ends_word(char letter) {
  return std::isalnum(static_cast<unsigned char>(letter)) == 0 &&
         std::string_view("/._-~").find(letter) == std::string_view::npos;
}

std::string prefix_of(const fs::path& folder) {
  const std::string quoted = nlohmann::json((folder / "").string()).dump();
  return quoted.substr(1, quoted.size() - 2);
}

}  // namespace

/// The longest comes first: it may hold another one.
CellNames::CellNames(const fs::path& cell_file) {
  for (const fs::path& file : {fs::weakly_canonical(cell_file), fs::absolute(cell_file), cell_file})
    if (file.has_parent_path()) prefixes_.push_back(prefix_of(file.parent_path()));
}

std::string CellNames::in(std::string text) const {
  for (const std::string& prefix : prefixes_)
    for (std::size_t at = 0; (at = text.find(prefix, at)) != std::string::npos;) {
      if (at > 0 && !ends_word(text[at - 1]))
        ++at;
      else
        text.erase(at, prefix.size());
    }
  return text;
}

}  // namespace planar
