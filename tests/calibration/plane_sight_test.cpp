#include "planar_servo/calibration/plane_sights.h"

#include <catch2/catch.hpp>

#include "calibration/synthetic_cell.h"
#include "support/finite_differences.h"

namespace planar {
namespace {

constexpr double kStep = 1e-4;
constexpr double kFourthOrder = 1e-8;  // step^4 and rounding over the step

const std::array<Eigen::Vector3d, 2> kRays_C{Eigen::Vector3d(0.2, -0.1, 1.0),
                                             Eigen::Vector3d(0.23, -0.08, 1.0)};

}  // namespace

TEST_CASE("The lamps' place and direction have the derivatives that finite differences have") {
  const Pose X_WC = test::SyntheticCell::looking_down();
  const auto seen_at = [&](const Eigen::VectorXd& change) -> Eigen::VectorXd {
    const LampsInPlane lamps = lamps_in_plane(moved_pose(X_WC, change), kRays_C).value();
    return Eigen::Vector3d(lamps.middle.x(), lamps.middle.y(), lamps.phi);
  };
  const LampsInPlane lamps = lamps_in_plane(X_WC, kRays_C).value();
  PoseJacobian<3> analytic;
  analytic << lamps.d_middle_d_pose, lamps.d_phi_d_pose;
  CHECK(test::jacobian_mismatch(analytic, seen_at, Eigen::VectorXd::Zero(6), kStep) < kFourthOrder);
}

TEST_CASE("A ray away from the plane, or a camera below it, meets nothing") {
  Pose X_WC = test::SyntheticCell::looking_down();
  CHECK_FALSE(meet_plane(X_WC, {0.0, 0.0, -1.0}));
  X_WC.translation().z() = -1.0;
  CHECK_FALSE(meet_plane(X_WC, {0.0, 0.0, 1.0}));
}

}  // namespace planar
