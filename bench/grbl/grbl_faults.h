#pragma once

#include <filesystem>
#include <string>

namespace planar {

/// Prints what a board's driver makes of each fault in the middle of a move. Without a simulator
/// the board is emulated. Times are the worst of `repeats`.
void print_fault_table(const std::string& name, const std::filesystem::path& simulator,
                       int repeats);

}  // namespace planar
