#include "planar_servo/calibration/plane/plane_start.h"

#include <Eigen/LU>
#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/decompositions.h"

namespace planar {

Pose pose_from_homography(const Eigen::Matrix3d& H_CW) {
  if (!(H_CW.determinant() < 0.0)) {
    throw InputError(
        "workplane: the tracker's positions are the mirror image of what the camera sees; check "
        "that no monuments are exchanged and that their coordinates are right");
  }
  const Eigen::Matrix3d M = 2.0 / (H_CW.col(0).norm() + H_CW.col(1).norm()) * H_CW;
  Eigen::Matrix3d axes;
  axes << M.col(0), M.col(1), M.col(0).cross(M.col(1));
  const SingularValues svd = singular_values(axes);
  Pose X_CW = Pose::Identity();
  X_CW.linear() = svd.U * svd.V.transpose();
  X_CW.translation() = M.col(2);
  return X_CW.inverse();
}

CameraPlane board_plane(const Pose& X_CG, double points_height) {
  const Eigen::Vector3d normal = X_CG.linear().col(2);
  const double distance = -normal.dot(X_CG.translation());
  if (!X_CG.matrix().allFinite() || distance == 0.0) {
    throw InputError("workplane: a board on the plane has no usable pose");
  }
  return distance > 0.0 ? CameraPlane{normal, distance + points_height}
                        : CameraPlane{-normal, -distance + points_height};
}

CameraPlane mean_plane(const std::vector<CameraPlane>& planes) {
  if (planes.empty()) {
    throw InputError(
        "workplane: no board was found on the plane; record views of plan 'plane_grid'");
  }
  CameraPlane mean{Eigen::Vector3d::Zero(), 0.0};
  for (const CameraPlane& plane : planes) {
    mean.normal_C += plane.normal_C;
    mean.distance += plane.distance / static_cast<double>(planes.size());
  }
  mean.normal_C.normalize();
  return mean;
}

Eigen::Matrix3d scatter_of_planes(const Pose& X_WC, const std::vector<CameraPlane>& planes) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (planes.size() < 2) return covariance;
  const auto n = static_cast<double>(planes.size());
  for (const CameraPlane& plane : planes) {
    const Eigen::Vector3d normal_W = X_WC.linear() * plane.normal_C;
    const Eigen::Vector3d change(plane.distance - X_WC.translation().z(), normal_W.y(),
                                 -normal_W.x());
    covariance += change * change.transpose() / (n * (n - 1.0));
  }
  return covariance;
}

Pose pose_over_plane(const CameraPlane& plane) {
  const Eigen::Vector3d z = plane.normal_C;
  const Eigen::Vector3d x = (Eigen::Vector3d::UnitX() - z.x() * z).normalized();
  Pose X_WC = Pose::Identity();
  X_WC.linear() << x.transpose(), z.cross(x).transpose(), z.transpose();
  X_WC.translation() = plane.distance * Eigen::Vector3d::UnitZ();
  return X_WC;
}

}  // namespace planar
