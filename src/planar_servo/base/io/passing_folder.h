#pragma once

#include <filesystem>
#include <string>

namespace planar {

/// A folder for temporary files, which goes with all of them when this ends.
class PassingFolder {
 public:
  /// Its name begins with this. Throws WorkError when no folder can be made.
  explicit PassingFolder(const std::string& name);
  ~PassingFolder();
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace planar
