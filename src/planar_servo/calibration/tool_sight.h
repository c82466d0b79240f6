#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "planar_servo/core/plan.h"

namespace planar {

/// The tool at rest at one place, as the camera saw it: the means of its frames there.
struct PoseSight {
  std::string id;
  Plan plan{Plan::kTrain};
  double t_s{0.0};                       ///< of its first frame
  Eigen::Vector3d theta{0.0, 0.0, 0.0};  ///< commanded joint angles, radians
  std::array<Eigen::Vector2d, 2> lamps_px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<Eigen::Matrix2d, 2> covariances_px2{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
};

/// The tool at a place that the tracker watched, too, with the mean of its readings there.
struct ToolSight : PoseSight {
  /// Number of the joint-3 sweep of this place; the places of one sweep share the end point.
  /// kNoSweep for places outside a sweep.
  int sweep{kNoSweep};
  Eigen::Vector3d p_reflector_B{0.0, 0.0, 0.0};  ///< metres
  double sigma_tracker{0.0};                     ///< per axis, metres

  static constexpr int kNoSweep = -1;
};

/// Names something that was left out and says why.
struct Rejection {
  std::string id;
  std::string reason;
};

}  // namespace planar
