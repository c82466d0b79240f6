#include "planar_servo/calibration/plane/plane_sight.h"

#include <cmath>

#include "planar_servo/core/pose.h"

namespace planar {
std::optional<Eigen::Vector2d> meet_plane(const Pose& X_WC, const Eigen::Vector3d& ray_C,
                                          PoseJacobian<2>* d_p_d_pose) {
  const Eigen::Vector3d c = X_WC.translation();
  const Eigen::Vector3d d = X_WC.linear() * ray_C;
  if (!(c.z() > 0.0 && d.z() < 0.0)) return std::nullopt;
  const Eigen::Vector2d slope = d.head<2>() / d.z();
  if (d_p_d_pose) {
    Eigen::Matrix<double, 2, 3> along;  // projects a displacement along the ray into the plane
    along << Eigen::Matrix2d::Identity(), -slope;
    *d_p_d_pose << along, c.z() / d.z() * along * cross_matrix(d);
  }
  return c.head<2>() - c.z() * slope;
}

std::optional<LampsInPlane> lamps_in_plane(const Pose& X_WC,
                                           const std::array<Eigen::Vector3d, 2>& rays_C) {
  PoseJacobian<2> J_A, J_B;
  const std::optional<Eigen::Vector2d> a = meet_plane(X_WC, rays_C[0], &J_A);
  const std::optional<Eigen::Vector2d> b = meet_plane(X_WC, rays_C[1], &J_B);
  if (!a || !b) return std::nullopt;
  const Eigen::Vector2d ab = *b - *a;
  if (!(ab.squaredNorm() > 0.0)) return std::nullopt;
  const Eigen::Vector2d normal(-ab.y(), ab.x());
  return LampsInPlane{0.5 * (*a + *b), std::atan2(ab.y(), ab.x()), 0.5 * (J_A + J_B),
                      normal.transpose() * (J_B - J_A) / ab.squaredNorm()};
}

Pose moved_pose(const Pose& X_WC, const Eigen::Matrix<double, 6, 1>& change) {
  Pose moved = X_WC;
  moved.translation() += change.head<3>();
  moved.linear() = rotation_from_vector(change.tail<3>()) * X_WC.linear();
  return moved;
}

}  // namespace planar
