#include "planar_servo/calibration/camera/camera_uncertainty.h"

namespace planar {
namespace {

Eigen::Array4d four_of(const CameraModel& camera) {
  const Intrinsics k = intrinsics(camera);
  return {k.fx, k.fy, k.cx, k.cy};
}

}  // namespace

Eigen::VectorXd deviations(const CameraUncertainty& uncertainty, const CameraModel& camera) {
  Eigen::VectorXd variances = uncertainty.by_residuals.diagonal();
  if (const auto& by_views = uncertainty.by_views) {
    auto known = variances.head(by_views->rows());
    known = known.cwiseMax(by_views->diagonal());
  }
  Eigen::Array4d differences = Eigen::Array4d::Zero();
  for (const CameraModel& other : uncertainty.as_good)
    differences = differences.max((four_of(other) - four_of(camera)).abs());
  variances.head<4>().array() += differences.square();
  return variances.cwiseSqrt();
}

}  // namespace planar
