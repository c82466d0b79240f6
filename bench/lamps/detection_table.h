#pragma once

#include <nlohmann/json.hpp>

namespace planar::bench {

/// Looks for two lamps in so many full frames of every kind, by every method in turn, each with the
/// frame out of the caches; prints times over that of one full read, misses and false finds, and
/// returns the same figures.
nlohmann::json measure_detection(int frames, unsigned seed);

}  // namespace planar::bench
