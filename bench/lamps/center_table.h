#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lamps/lamp_families.h"

namespace planar::bench {

/// Measures `positions` lamps of every family by every method, interleaved; prints rms errors per
/// axis beside the Cramer-Rao bounds, times and how honest the stated covariances are, and returns
/// the same figures.
nlohmann::json measure_centers(const std::vector<LampFamily>& families, int positions,
                               unsigned seed);

}  // namespace planar::bench
