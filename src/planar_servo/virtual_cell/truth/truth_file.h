#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Reads truth.yaml. Throws InputError with every fault of the file: an unknown or missing key, a
/// wrong type, a number that is not finite or out of its range.
Truth read_truth(const std::filesystem::path& path);

/// Returns the whole file's text. Reading it gives the same cell up to the rounding of units.
std::string truth_text(const Truth& truth);

/// Writes the whole file. Throws WorkError when the path cannot be written.
void write_truth(const std::filesystem::path& path, const Truth& truth);

}  // namespace planar
