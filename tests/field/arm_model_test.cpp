#include "planar_servo/field/arm/arm_model.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"
#include "support/finite_differences.h"

namespace planar {
namespace {

TEST_CASE("An arm as its files say it is predicts the points of its tool by plain kinematics") {
  const test::BentCell cell;
  const ArmNominal files = cell.nominal();
  const ArmModel model(files, {2, true});
  const Eigen::Vector3d motors(0.4, 1.1, -0.6);
  const ToolPoints seen = model.at(motors, model.nominal());
  const PlanarArm arm(files.geometry);
  const TipPose tip = arm.forward(files.joints_per_motor * motors);
  CHECK((seen.tip.p - tip.p).norm() < 1e-12);
  CHECK(seen.tip.phi == Approx(tip.phi));
  const Eigen::Vector2d reflector = tip.p + rotation2d(tip.phi) * files.tool.p_TS.head<2>();
  CHECK((seen.points.col(0) - reflector).norm() < 1e-12);
  CHECK((seen.points.col(2) - seen.points.col(1)).norm() == Approx(files.separation));
}

TEST_CASE("The derivatives by every unknown agree with finite differences") {
  const test::BentCell cell;
  std::mt19937 random(4);
  std::normal_distribution<double> noise;
  for (const int harmonics : {0, 1, 3}) {
    const ArmModel model(cell.nominal(), {harmonics, true});
    const Eigen::VectorXd sigma = model.prior_sigma();
    for (int draw = 0; draw < 20; ++draw) {
      const Eigen::Vector3d motors = test::BentCell::random_motors(random);
      Eigen::VectorXd x = model.nominal();
      for (Eigen::Index k = 0; k < x.size(); ++k) x[k] += sigma[k] * noise(random);
      const ArmModel::Jacobian J = model.jacobian(motors, x);
      for (Eigen::Index k = 0; k < x.size(); ++k) {
        const double step = 1e-3 * sigma[k];
        Eigen::VectorXd more = x, less = x;
        more[k] += step;
        less[k] -= step;
        const Eigen::Matrix<double, 2, 3> slope =
            (model.at(motors, more).points - model.at(motors, less).points) / (2.0 * step);
        const Eigen::Map<const Eigen::Matrix<double, 6, 1>> expected(slope.data());
        // The lamps' height is left out of the other columns: it changes them by a thousandth.
        CHECK((J.col(k) - expected).norm() < 5e-3 * expected.norm() + 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace planar
