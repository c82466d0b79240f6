#pragma once

#include <filesystem>
#include <string>

namespace planar {

/// Asked before the work that a GrowingFile takes: throws InputError when it could not be begun or
/// gone on with, because it is a folder or closed to this user, or its folder is.
void require_growable(const std::filesystem::path& path);

/// A table that grows during a run, whole lines at a time; what was written survives a crash.
class GrowingFile {
 public:
  /// Makes the file with its header, or goes on with the one that is there unless it is empty.
  /// Throws like require_growable().
  GrowingFile(std::filesystem::path path, const std::string& header);

  /// Throws WorkError when the disk takes no more.
  void append(const std::string& lines);

 private:
  std::filesystem::path path_;
};

/// Makes a folder and those above it. Throws InputError when that cannot be done.
void make_folder(const std::filesystem::path& path);

}  // namespace planar
