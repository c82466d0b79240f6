#include "planar_servo/base/io/passing_folder.h"

#include <cstdlib>

#include "planar_servo/base/core/error.h"

namespace planar {

namespace fs = std::filesystem;

PassingFolder::PassingFolder(const std::string& name) {
  std::string pattern = (fs::temp_directory_path() / (name + "-XXXXXX")).string();
  if (mkdtemp(pattern.data()) == nullptr)
    throw WorkError({"no folder can be made there", "is the disk full?", pattern});
  path_ = pattern;
}

PassingFolder::~PassingFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace planar
