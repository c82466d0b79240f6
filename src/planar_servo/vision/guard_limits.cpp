#include "planar_servo/vision/guard_limits.h"

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

GuardLimits guard_limits(const VisionCalibration& vision, const Workspace& workspace, double phi) {
  GuardLimits limits;
  if (vision.error_map)
    limits.correction_m = kBeyondLongest * longest_correction(vision, workspace.radius_max_m, phi);
  return limits;
}

}  // namespace planar
