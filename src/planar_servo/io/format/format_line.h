#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace planar {

/// Returns KIND of the first line `format: planar-servo/KIND/1`, which tables have behind a '#';
/// empty for another text.
std::string_view kind_of_text(std::string_view text);

/// Returns the same of a file; empty for one that is not there or is no file.
std::string kind_of_file(const std::filesystem::path& path);

/// Returns the present time as our files have it, such as "2026-11-22T08:17:53Z".
std::string utc_now();

}  // namespace planar
