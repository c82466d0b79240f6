#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>

#include "planar_servo/arm/planar_arm.h"

namespace planar {

/// Where the end point is by somebody who is not the servo's own camera.
struct JudgedPoint {
  std::optional<Eigen::Vector2d> p;  ///< base frame, metres; empty where nobody could tell
  double sigma{0.0};                 ///< of p per axis, metres
  std::string fault;                 ///< why nobody could tell; empty where somebody could
};

/// Measures the end point of the arm, which rests at the joints commanded last, on its way to the
/// target `id` or at it.
using EndPointJudge = std::function<JudgedPoint(const std::string& id, const Joints& commanded)>;

}  // namespace planar
