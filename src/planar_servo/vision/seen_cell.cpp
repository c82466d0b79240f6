#include "planar_servo/vision/seen_cell.h"

#include <algorithm>

namespace planar {
namespace {

/// The map is smooth over a twentieth of the workspace's radius.
constexpr int kHalfGrid = 20;
constexpr double kBeyondLongest = 1.5;

double longest_correction(const VisionCalibration& vision, double radius_m, double phi) {
  double longest = 0.0;
  for (int i = -kHalfGrid; i <= kHalfGrid; ++i) {
    for (int j = -kHalfGrid; j <= kHalfGrid; ++j) {
      const Eigen::Vector2d p = radius_m / kHalfGrid * Eigen::Vector2d(i, j);
      if (p.norm() > radius_m) continue;
      const ErrorPrediction error = predict_error_at(vision, {p, phi});
      if (error.inside) longest = std::max(longest, error.error.norm());
    }
  }
  return longest;
}

}  // namespace

CellModel model_of_cell(const JointPlanner& planner, const Joints& home,
                        const VisionCalibration& vision) {
  const Eigen::Vector2d half(0.5 * vision.lamps.separation_m, 0.0);
  const Pose& X_WC = vision.workplane.X_WC();
  const Eigen::Vector3d axis = X_WC.linear().col(2);
  CellModel model;
  model.sense = planner.arm().sense();
  model.links_m = planner.arm().geometry().link_lengths_m;
  model.coupling = planner.transmission().coupling_matrix();
  model.home = planner.transmission().motors_from_joints(home);
  model.lamps_T = {-half - vision.tool.p_TP, half - vision.tool.p_TP};
  model.axis_B = (X_WC.translation() - axis * (X_WC.translation().z() / axis.z())).head<2>();
  return model;
}

GuardLimits guard_limits(const VisionCalibration& vision, const Workspace& workspace, double phi) {
  GuardLimits limits;
  if (vision.error_map)
    limits.correction_m = kBeyondLongest * longest_correction(vision, workspace.radius_max_m, phi);
  return limits;
}

}  // namespace planar
