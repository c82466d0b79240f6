#include "planar_servo/geometry/lens/workplane.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/lens/lens_models.h"

namespace planar {
namespace {

const Intrinsics kUnequalLens{4200.0, 4100.0, 2560.0, 2500.0};
constexpr double kDistance = 1.25;

/// A plane tilted about an axis of its own, its origin on the camera's axis.
Pose tilted_plane(double tilt, double about) {
  Pose X_CG = Pose::Identity();
  const Eigen::Vector3d axis(std::cos(about), std::sin(about), 0.0);
  X_CG.linear() = Eigen::AngleAxisd(tilt, axis).toRotationMatrix() *
                  Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  X_CG.translation() = Eigen::Vector3d(0.0, 0.0, kDistance);
  return X_CG;
}

/// Centre of the image of a disc without lens distortion: the disc's conic Q goes to
/// H^-T Q H^-1, whose centre is the pole of the line at infinity.
Eigen::Vector2d imaged_disc_center(const Pose& X_CG, const Eigen::Vector2d& p, double diameter) {
  Eigen::Matrix3d K, disc;
  K << kUnequalLens.fx, 0.0, kUnequalLens.cx, 0.0, kUnequalLens.fy, kUnequalLens.cy, 0.0, 0.0, 1.0;
  disc << 1.0, 0.0, -p.x(), 0.0, 1.0, -p.y(), -p.x(), -p.y(),
      p.squaredNorm() - 0.25 * diameter * diameter;
  Eigen::Matrix3d H;
  H << X_CG.linear().leftCols<2>(), X_CG.translation();
  H = K * H;
  const Eigen::Matrix3d dual = H * disc.inverse() * H.transpose();
  return (dual.col(2) / dual(2, 2)).head<2>();
}

TEST_CASE("eccentricity_px is that of the disc's exact projection, however the plane is tilted") {
  constexpr double kDiameter = 8.0 * kMillimetre;
  constexpr double kShare = 5e-3;     // a rim of 48 points has a smaller area than its circle
  constexpr double kRounding = 1e-7;  // px
  for (const double tilt : {0.0, 1.0, 10.0, 30.0, 60.0}) {
    for (const double about : {0.0, 0.7, 2.0}) {
      const Pose X_CG = tilted_plane(tilt * kDegree, about);
      for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.3, -0.2)}) {
        const Eigen::Vector3d p_C = X_CG * Eigen::Vector3d(p.x(), p.y(), 0.0);
        const Eigen::Vector2d exact =
            imaged_disc_center(X_CG, p, kDiameter) - *project(Pinhole{kUnequalLens}, p_C);
        const auto shift = eccentricity_px(Pinhole{kUnequalLens}, X_CG, p, kDiameter);
        REQUIRE(shift);
        CHECK((*shift - exact).norm() < kShare * exact.norm() + kRounding);
      }
    }
  }
}

TEST_CASE("eccentricity_px grows with the square of the radius and the tilt") {
  // On the axis the shift is about f r^2 sin(2 tilt) / (2 Z^2).
  const double tilt = 30.0 * kDegree, radius = 4.0 * kMillimetre;
  const double expected =
      kUnequalLens.fy * radius * radius * std::sin(2.0 * tilt) / (2.0 * kDistance * kDistance);
  const auto shift =
      eccentricity_px(Pinhole{kUnequalLens}, tilted_plane(tilt, 0.0), {0, 0}, 2.0 * radius);
  REQUIRE(shift);
  CHECK(shift->norm() == Approx(expected).epsilon(0.01));
}

}  // namespace
}  // namespace planar
