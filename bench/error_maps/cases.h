#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planar_servo/learn/error_map/error_sample.h"

namespace planar::bench {

/// A made-up field over a disc of radius 480 mm: f1 is residuals of a lens, f2 has a glow, f3 has
/// bumps, f4 is f1 with a seam of 0.41 mm, and f5 is f2 with noise that grows with the radius and
/// 2 % of the pairs off by 0.5 mm.
struct Case {
  std::string field;   ///< one of f1 ... f5
  std::string layout;  ///< random, rings or grid
  int count{200};      ///< number of pairs; a grid may have a few more
};

/// Returns the noisy pairs of one draw.
std::vector<ErrorSample> draw(const Case& c, std::uint32_t seed);

/// Returns 4,000 noise-free pairs, the same for every draw.
std::vector<ErrorSample> truth(const Case& c);

}  // namespace planar::bench
