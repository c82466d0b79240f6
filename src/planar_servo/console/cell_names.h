#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace planar {

/// Names the files of a cell's folder relative to it, in texts for those who do not see its disk.
class CellNames {
 public:
  /// Leaves all texts as they are.
  CellNames() = default;
  explicit CellNames(const std::filesystem::path& cell_file);

  std::string in(std::string text) const;

 private:
  std::vector<std::string> prefixes_;  ///< how the folder's files may be named, as JSON has it
};

}  // namespace planar
