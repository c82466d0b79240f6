#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace planar {

/// Returns KIND of the line `format: planar-servo/KIND/1` among the first four or as the last;
/// empty for a text without it, which is not ours. Tables have the line behind a '#', pages and
/// figures in a comment, JSON as a key, PDF at its end, NumPy's arrays in their head. Pictures have
/// none: they are of the kind `image`.
std::string_view kind_of_text(std::string_view text);

/// Returns a JSON object's text with the key `format` of this kind before its other keys.
std::string with_format_key(const std::string& kind, const std::string& object);

/// Returns the line that says the kind of a page or a figure, a comment of their language.
std::string format_comment(const std::string& kind);

/// Returns the line that says the kind of a PDF, behind its end.
std::string format_remark(const std::string& kind);

/// Says whether what was written survives only a crash of its program, or a loss of power as well,
/// for which the disk is waited for.
enum class Durability { kCrash, kPowerLoss };

/// Writes the whole text to an open file and closes it. Returns whether all of it is there.
bool write_and_close(int file, std::string_view text, Durability durability);

/// Lets the names in a folder survive a loss of power. Returns whether they do, as far as the file
/// system can say.
bool sync_folder(const std::filesystem::path& folder);

/// Writes the whole text to a temporary file beside `path` and renames it, so that no reader ever
/// sees half a file, not even after a loss of power. A device or a pipe, such as /dev/stdout, is
/// written directly. Throws WorkError when the place cannot be written, and InputError when a link
/// stands there or a file that is not ours of the same kind (see kind_of_text()); an empty one may
/// be replaced.
void write_file(const std::filesystem::path& path, std::string_view text);

/// Throws InputError when a link stands there, unless it leads to a device or a pipe.
void require_no_link(const std::filesystem::path& path);

/// Opens a file for reading. Throws InputError naming `path` when it cannot be read.
std::ifstream open_file(const std::filesystem::path& path);

/// Returns the text of the whole file. Throws InputError naming `path` when it cannot be read.
std::string read_file(const std::filesystem::path& path);

/// Throws InputError when `output` is the same file as `input`.
void require_not_input(const std::filesystem::path& output, const std::filesystem::path& input);

/// Throws InputError unless these outputs, each with its kind, have different names, none is an
/// input, and all can be written as require_writable() says. Empty names are left out.
void require_outputs(const std::vector<std::pair<std::filesystem::path, const char*>>& outputs,
                     const std::vector<std::filesystem::path>& inputs);

/// Throws InputError when write_file() could not write an output of this kind, because it is a
/// folder or a link, or because its folder is missing or closed to this user, or because a file
/// stands there that is not ours of this kind. What people write, a cell, a truth, targets or a
/// plan, is never replaced. Call it before the work whose result goes there.
void require_writable(const std::filesystem::path& output, std::string_view kind);

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
