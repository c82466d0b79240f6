#pragma once

#include <filesystem>
#include <vector>

namespace planar {

/// Removes the files and folders of a run that failed before it moved anything.
class RunFolder {
 public:
  /// Notes which of this folder, those above it and these files in it do not exist yet. Makes
  /// nothing.
  RunFolder(const std::filesystem::path& folder, const std::vector<const char*>& files);
  /// Removes what was noted, folders only if they are empty, when an exception ends the run, unless
  /// keep() was called.
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  void keep() { made_.clear(); }

 private:
  std::vector<std::filesystem::path> made_;  ///< the deepest first
  int exceptions_;                           ///< that were in flight at the beginning
};

}  // namespace planar
