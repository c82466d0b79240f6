#pragma once

#include <array>

namespace planar {

/// Holds how a lamp looks, wherever it is. Grey levels go from 0 to 255.
struct LampLook {
  double level{0.0};       ///< median of its pixels
  double background{0.0};  ///< median of the pixels round it
  double blur_px{0.0};     ///< standard deviation of its rim's blur; 0 where that was not measured
  double axis_ratio{0.0};  ///< minor to major axis

  double contrast() const { return level - background; }
};

/// How lamps 1 and 2 look.
using LampLooks = std::array<LampLook, 2>;

}  // namespace planar
