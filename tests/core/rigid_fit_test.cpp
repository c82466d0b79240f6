#include "planar_servo/base/core/pose.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kRigidRounding = 1e-13;  // m, on coordinates of metres
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

Pose tracker_pose() {
  Pose X_BL = Pose::Identity();
  X_BL.linear() = rotation_from_vector({0.1, -0.2, 2.1});
  X_BL.translation() = Eigen::Vector3d(2.5, -1.0, 0.7);
  return X_BL;
}

Eigen::Matrix3Xd cloud(Eigen::Index n) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  return Eigen::Matrix3Xd::NullaryExpr(3, n, [&] { return place(random); });
}

}  // namespace

TEST_CASE("A rigid motion is recovered exactly in the plane and in space") {
  const Eigen::Matrix3Xd p_L = cloud(5);
  const Eigen::Matrix3Xd p_B = tracker_pose() * p_L;
  CHECK(fit_rigid_3d(p_B, p_L).isApprox(tracker_pose(), kRigidRounding));

  const Eigen::Matrix2d R = rotation2d(2.9);
  const Eigen::Matrix2Xd q = p_L.topRows<2>();
  const Eigen::Matrix2Xd p = (R * q).colwise() + Eigen::Vector2d(0.3, -4.0);
  const Eigen::Isometry2d X = fit_rigid_2d(p, q);
  CHECK(X.linear().isApprox(R, kRigidRounding));
  CHECK((X.translation() - Eigen::Vector2d(0.3, -4.0)).norm() < kRigidRounding);
}

TEST_CASE("In the plane the fit is the closed form by the sums of dot and cross products") {
  Eigen::Matrix2Xd p = cloud(20).topRows<2>();
  const Eigen::Matrix2Xd q = rotation2d(-0.8) * p + 0.05 * cloud(20).bottomRows<2>();
  const Eigen::Matrix2Xd p0 = p.colwise() - p.rowwise().mean(),
                         q0 = q.colwise() - q.rowwise().mean();
  const double dots = (p0.array() * q0.array()).sum();
  const double crosses =
      (q0.row(0).array() * p0.row(1).array()).sum() - (q0.row(1).array() * p0.row(0).array()).sum();
  const Eigen::Matrix2d R = fit_rigid_2d(p, q).linear();
  CHECK(std::atan2(R(1, 0), R(0, 0)) == Approx(std::atan2(crosses, dots)).epsilon(1e-12));
}

TEST_CASE("A scaled cloud keeps its residual: no scale is absorbed") {
  constexpr double kScale = 1.01;
  const Eigen::Matrix3Xd p_L = cloud(30);
  const Eigen::Matrix3Xd p_B = tracker_pose() * Eigen::Matrix3Xd(kScale * p_L);
  const Pose X_BL = fit_rigid_3d(p_B, p_L);
  CHECK(X_BL.linear().isApprox(tracker_pose().linear(), 1e-12));
  const Eigen::Matrix3Xd centred = p_L.colwise() - p_L.rowwise().mean();
  const double residual = (X_BL * p_L - p_B).norm();
  CHECK(residual == Approx((kScale - 1.0) * centred.norm()).epsilon(1e-9));
}

TEST_CASE("A mirrored cloud gives a rotation, and a large residual") {
  const Eigen::Matrix3Xd p_L = cloud(10);
  const Eigen::Matrix3Xd p_B = Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal() * p_L;
  const Pose X = fit_rigid_3d(p_B, p_L);
  CHECK(X.linear().determinant() == Approx(1.0));
  CHECK((X * p_L - p_B).norm() > 1.0);
}

TEST_CASE("Points that determine no rigid motion are refused") {
  Eigen::Matrix3Xd line(3, 4);
  for (int i = 0; i < 4; ++i) line.col(i) = (i + 1.0) * Eigen::Vector3d(1.0, 2.0, -0.5);
  CHECK_THROWS_MATCHES(fit_rigid_3d(line, line), InputError,
                       Refused(Cause::kInsufficient, "rigid fit"));
  const Eigen::Matrix2Xd one_place = Eigen::Matrix2Xd::Ones(2, 3);
  CHECK_THROWS_MATCHES(fit_rigid_2d(one_place, one_place), InputError,
                       Refused(Cause::kInsufficient, "rigid fit"));
  CHECK_THROWS_MATCHES(fit_rigid_3d(cloud(2), cloud(2)), InputError,
                       Refused(Cause::kInsufficient, "2 points"));
  Eigen::Matrix3Xd broken = cloud(4);
  broken(1, 2) = kNotANumber;
  CHECK_THROWS_MATCHES(fit_rigid_3d(broken, cloud(4)), InputError,
                       Refused(Cause::kInvalid, "rigid fit"));
  CHECK_THROWS_AS(fit_rigid_3d(cloud(4), cloud(5)), std::invalid_argument);
}

}  // namespace planar
