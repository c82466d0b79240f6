#pragma once

#include <filesystem>
#include <string_view>

namespace planar {

/// Says whether what was written survives only a crash of its program, or a loss of power as well,
/// for which the disk is waited for.
enum class Durability { kCrash, kPowerLoss };

/// Writes the whole text to an open file and closes it. Returns whether all of it is there.
bool write_and_close(int file, std::string_view text, Durability durability);

/// Lets the names in a folder survive a loss of power. Returns whether they do, as far as the file
/// system can say.
bool sync_folder(const std::filesystem::path& folder);

}  // namespace planar
