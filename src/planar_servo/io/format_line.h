#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace planar {

/// Returns KIND of the line `format: planar-servo/KIND/1` among the first four; empty for a text
/// without it, which is not ours. Tables have the line behind a '#', pages and figures in a
/// comment, JSON has it as a key. Pictures have none: they are of the kind `image`.
std::string_view kind_of_text(std::string_view text);

/// Returns a JSON object's text with the key `format` of this kind before its other keys.
std::string with_format_key(const std::string& kind, const std::string& object);

/// Returns the line that says the kind of a page or a figure, a comment of their language.
std::string format_comment(const std::string& kind);

/// Returns the kind of a file; empty for one that is not there or is no file.
std::string kind_of_file(const std::filesystem::path& path);

/// Returns the present time as our files have it, such as "2026-11-22T08:17:53Z".
std::string utc_now();

}  // namespace planar
