#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planar_servo/error_map/error_sample.h"

namespace planar::bench {

/// Made-up fields over a disc of 480 mm: f1 lens residuals, f2 with a glow, f3 with bumps, f4 f1
/// with a seam of 0.41 mm, f5 f2 with noise growing with the radius and 2 % of the pairs off by
/// 0.5 mm.
struct Case {
  std::string field;   ///< f1 ... f5
  std::string layout;  ///< random, rings or grid
  int count{200};      ///< pairs (a grid may have a few more)
};

/// Noisy pairs of one draw.
std::vector<ErrorSample> draw(const Case& c, std::uint32_t seed);

/// 4,000 noise-free pairs, the same for every draw.
std::vector<ErrorSample> truth(const Case& c);

}  // namespace planar::bench
