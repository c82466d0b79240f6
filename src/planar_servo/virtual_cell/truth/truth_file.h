#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// truth.yaml of the contract. Throws InputError with every fault of the file: an unknown or
/// missing key, a wrong type, a number that is not finite or out of its range.
Truth read_truth(const std::filesystem::path& path);

/// The whole file's text. read_truth gives the same cell up to the rounding of units.
std::string truth_text(const Truth& truth);

/// Writes truth_text whole. Throws WorkError when the place cannot be written.
void write_truth(const std::filesystem::path& path, const Truth& truth);

}  // namespace planar
