#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

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

/// A lamp that is fixed to the base, in the camera's view.
struct ReferenceLampLayout {
  std::string id;
  double diameter_m{0.0};
  std::optional<Eigen::Vector2d> p_B;  ///< its place in the base frame, where that is known
};

}  // namespace planar
