#pragma once

#include <nlohmann/json.hpp>

namespace planar::bench {

/// Looks for two lamps in `frames` full frames of every kind, by every method in turn, each time
/// with the frame out of the caches. Prints times over that of one full read, misses and false
/// finds. Returns the same figures.
nlohmann::json measure_detection(int frames, unsigned seed);

}  // namespace planar::bench
