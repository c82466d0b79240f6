#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

namespace planar {

/// The tool at rest in one place, as the camera and the tracker saw it: means over the frames and
/// the readings of that place.
struct ToolSight {
  std::string id;
  std::string plan;
  /// Number of the joint-3 sweep that this place belongs to: places of one sweep share the end
  /// point. kNoSweep for all others.
  int sweep{kNoSweep};
  std::array<Eigen::Vector2d, 2> lamps_px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<Eigen::Matrix2d, 2> covariances_px2{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  Eigen::Vector3d p_reflector_B{0.0, 0.0, 0.0};  ///< metres
  double sigma_tracker{0.0};                     ///< per axis, metres

  static constexpr int kNoSweep = -1;
};

/// What was left out, and why, in words.
struct Rejection {
  std::string id;
  std::string reason;
};

}  // namespace planar
