#pragma once

#include <filesystem>
#include <vector>

namespace planar::test {

/// From the beginning of the exposure that a correction was computed from, as the run logged it, to
/// the first command that followed on the wire, seconds; one for every correction of the run.
/// Throws InputError for a folder that holds no run.
std::vector<double> exposure_to_command_s(const std::filesystem::path& run,
                                          const std::vector<double>& commands_s);

}  // namespace planar::test
