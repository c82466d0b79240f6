#pragma once

#include <filesystem>

namespace planar {

/// Keeps a folder to one program at a time, so that no two write its tables. The lock ends with
/// this object or with the program, however that ends, and leaves no file behind.
class FolderLock {
 public:
  /// Throws InputError when another program holds the folder, or when it cannot be opened.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace planar
