#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace planar {

/// Returns the words of the kinds of drives for which a cell file can be written.
std::vector<std::string> new_cell_drives();

/// Writes a cell file with a comment at each value, to be filled in by hand, for drives of a kind
/// of new_cell_drives(). Throws InputError when something stands at `path` already or nothing can
/// be written there.
void write_new_cell(const std::filesystem::path& path, const std::string& drives);

}  // namespace planar
