#pragma once

namespace planar {

/// Prints the time from a command to the first pulse of the emulated board.
void print_start_time(int repeats);

}  // namespace planar
