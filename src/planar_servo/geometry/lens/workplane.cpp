#include "planar_servo/geometry/lens/workplane.h"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr int kRimPoints = 48;

Eigen::Vector3d in_camera(const Pose& X_CG, const Eigen::Vector2d& p_G) {
  return X_CG * Eigen::Vector3d(p_G.x(), p_G.y(), 0.0);
}

}  // namespace

Workplane::Workplane(const CameraModel& camera, const Pose& X_WC)
    : camera_(camera), X_WC_(X_WC), X_CW_(X_WC.inverse()) {}

std::optional<Eigen::Vector2d> Workplane::plane_from_pixel(const Eigen::Vector2d& uv_px,
                                                           Eigen::Matrix2d* d_p_d_uv) const {
  Eigen::Matrix2d d_xy_d_uv;
  const auto ray_C = ray(camera_, uv_px, &d_xy_d_uv);
  if (!ray_C) return std::nullopt;
  const Eigen::Matrix3d R_WC = X_WC_.linear();
  const Eigen::Vector3d center_W = X_WC_.translation();
  const Eigen::Vector3d ray_W = R_WC * *ray_C;
  const double depth = -center_W.z() / ray_W.z();
  const Eigen::Vector2d p_W = center_W.head<2>() + depth * ray_W.head<2>();
  if (!(depth > 0.0) || !p_W.allFinite()) return std::nullopt;
  if (d_p_d_uv != nullptr) {
    Eigen::Matrix<double, 2, 3> d_p_d_ray;
    d_p_d_ray << Eigen::Matrix2d::Identity(), -ray_W.head<2>() / ray_W.z();
    *d_p_d_uv = depth * d_p_d_ray * R_WC.leftCols<2>() * d_xy_d_uv;
  }
  return p_W;
}

std::optional<Eigen::Vector2d> Workplane::pixel_from_plane(const Eigen::Vector2d& p_W,
                                                           Eigen::Matrix2d* d_uv_d_p) const {
  Eigen::Matrix<double, 2, 3> d_uv_d_p_C;
  const Eigen::Vector3d p_C = X_CW_ * Eigen::Vector3d(p_W.x(), p_W.y(), 0.0);
  auto uv_px = project(camera_, p_C, &d_uv_d_p_C);
  if (uv_px && d_uv_d_p != nullptr) *d_uv_d_p = d_uv_d_p_C * X_CW_.linear().leftCols<2>();
  return uv_px;
}

std::optional<Eigen::Vector2d> eccentricity_px(const CameraModel& camera, const Pose& X_CG,
                                               const Eigen::Vector2d& p_GD, double diameter) {
  const auto center = project(camera, in_camera(X_CG, p_GD));
  if (!center) return std::nullopt;
  std::array<Eigen::Vector2d, kRimPoints> rim;
  for (int i = 0; i < kRimPoints; ++i) {
    const double angle = 2.0 * kPi * i / kRimPoints;
    const Eigen::Vector2d radius =
        0.5 * diameter * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const auto pixel = project(camera, in_camera(X_CG, p_GD + radius));
    if (!pixel) return std::nullopt;
    rim[i] = *pixel - *center;
  }
  // This is the centroid of the polygon's area.
  double twice_area = 0.0;
  Eigen::Vector2d moment{0.0, 0.0};
  for (int i = 0; i < kRimPoints; ++i) {
    const Eigen::Vector2d& a = rim[i];
    const Eigen::Vector2d& b = rim[(i + 1) % kRimPoints];
    twice_area += cross2d(a, b);
    moment += cross2d(a, b) * (a + b);
  }
  return Eigen::Vector2d(moment / (3.0 * twice_area));
}

std::optional<double> disc_diameter(const CameraModel& camera, const Pose& X_CG,
                                    const Eigen::Vector2d& p_GD, double area_px2) {
  Eigen::Matrix<double, 2, 3> d_uv_d_p;
  if (!project(camera, in_camera(X_CG, p_GD), &d_uv_d_p)) return std::nullopt;
  const Eigen::Matrix2d d_uv_d_G = d_uv_d_p * X_CG.linear().leftCols<2>();
  return 2.0 * std::sqrt(area_px2 / (kPi * std::abs(d_uv_d_G.determinant())));
}

}  // namespace planar
