#include "planar_servo/work/run/run_folder.h"

#include <exception>
#include <system_error>

namespace planar {

namespace fs = std::filesystem;

RunFolder::RunFolder(const fs::path& folder, const std::vector<const char*>& files)
    : exceptions_(std::uncaught_exceptions()) {
  for (const char* file : files)
    if (!fs::exists(folder / file)) made_.push_back(folder / file);
  const fs::path whole = fs::absolute(folder).lexically_normal();
  for (fs::path at = whole; !fs::exists(at) && at.has_relative_path(); at = at.parent_path())
    made_.push_back(at);
}

RunFolder::~RunFolder() {
  if (std::uncaught_exceptions() <= exceptions_) return;
  std::error_code error;
  for (const fs::path& path : made_) fs::remove(path, error);
}

}  // namespace planar
