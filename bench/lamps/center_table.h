#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lamps/lamp_families.h"

namespace planar::bench {

/// Measures `positions` lamps of every family by every method in turn. Prints rms errors per axis
/// beside the Cramer-Rao bounds, times, and how honest the stated covariances are. Returns the same
/// figures.
nlohmann::json measure_centers(const std::vector<LampFamily>& families, int positions,
                               unsigned seed);

}  // namespace planar::bench
