#include "planar_servo/tool/disc_image.h"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr int kRimPoints = 48;

Eigen::Vector3d in_camera(const Pose& X_CG, const Eigen::Vector2d& p_G) {
  return X_CG * Eigen::Vector3d(p_G.x(), p_G.y(), 0.0);
}

}  // namespace

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
