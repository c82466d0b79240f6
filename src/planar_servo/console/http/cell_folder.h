#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// A file of the cell's folder as it is served.
struct ServedFile {
  std::filesystem::path path;
  const char* type{""};  ///< MIME type
};

/// Returns a page or picture below `folder`, which is an absolute path without links, named
/// relatively to it. Empty for anything else: a name that leads out, a link, another kind of file.
std::optional<ServedFile> served_file(const std::filesystem::path& folder, const std::string& name);

/// Returns the pages of earlier work below the folder, the newest first.
nlohmann::ordered_json reports_json(const std::filesystem::path& folder);

/// Returns the cell's calibration files with what made them and what is wrong with them, and what
/// `planar next` says for this calibration board.
nlohmann::ordered_json files_json(const CellSettings& cell, const std::string& board);

}  // namespace planar
