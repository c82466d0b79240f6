#pragma once

#include <array>

namespace planar {

/// The two lamps on the tool as they were built: the distance of their centres and their
/// diameters, metres.
struct LampLayout {
  double separation_m{0.0};
  std::array<double, 2> diameters_m{0.0, 0.0};

  std::array<double, 2> diameter_over_separation() const {
    return {diameters_m[0] / separation_m, diameters_m[1] / separation_m};
  }
};

}  // namespace planar
