#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/io/atomic_file.h"

namespace planar {

/// Reserves a folder for one program at a time, so that no two write its tables. The lock ends with
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

/// Throws InputError when a GrowingFile could not begin or continue the file, because it is a
/// folder, a link or closed to this user, or because its folder is missing or closed. Call it
/// before the work whose results go there.
void require_growable(const std::filesystem::path& path);

/// Cuts off what follows the last line end of a file that grew by whole lines below this header: a
/// row that was being written when its program was killed. Call it before such a file is read to be
/// continued. Nothing happens when the file does not exist or ends with a whole line. Throws
/// InputError when the file cannot be read or cut, or is another one: a link, or one that does not
/// begin with the header's first line and have its columns.
void drop_torn_line(const std::filesystem::path& path, const std::string& header);

/// Throws InputError when a file is there that does not begin with this header.
void require_header(const std::filesystem::path& path, const std::string& header);

/// Returns whether such a file does not exist or holds its header alone.
bool holds_no_row(const std::filesystem::path& path, const std::string& header);

/// Writes a table that grows during a run by whole lines. What was written survives a crash.
class GrowingFile {
 public:
  /// Makes the file with its header, or continues the file that is there, without a torn last line,
  /// unless it is empty. Throws as require_growable() and drop_torn_line() do.
  GrowingFile(std::filesystem::path path, const std::string& header);

  /// Appends whole lines. Throws WorkError when they cannot be written, as on a full disk.
  void append(const std::string& lines, Durability durability = Durability::kCrash);

 private:
  std::filesystem::path path_;
};

/// Makes a folder and those above it, which survive a loss of power. Throws InputError when that
/// cannot be done.
void make_folder(const std::filesystem::path& path);

}  // namespace planar
