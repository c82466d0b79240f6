#include "planar_servo/learn/field/arm/arm_model.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"

namespace planar {
namespace {

TEST_CASE("An arm as its files say it is predicts the points of its tool by plain kinematics") {
  const test::BentCell cell;
  const ArmNominal files = cell.nominal();
  const ArmModel model(files, {2, true});
  const Eigen::Vector3d motors(0.4, 1.1, -0.6);
  const ToolPoints seen = model.at({motors, 0.0}, model.nominal());
  const PlanarArm arm(files.geometry);
  const TipPose tip = arm.forward(files.joints_per_motor * motors);
  CHECK((seen.tip.p - tip.p).norm() < 1e-12);
  CHECK(seen.tip.phi == Approx(tip.phi));
  const Eigen::Vector2d reflector = tip.p + rotation2d(tip.phi) * files.tool.p_TS.head<2>();
  CHECK((seen.points.col(0) - reflector).norm() < 1e-12);
  CHECK((seen.points.col(2) - seen.points.col(1)).norm() == Approx(files.separation));
}

/// Everything that a model may have, about postures and places that a cell's arm takes.
ArmModelSize whole_size(std::mt19937& random, const ArmNominal& files) {
  std::vector<Joints> postures;
  postures.reserve(30);
  for (int i = 0; i < 30; ++i)
    postures.emplace_back(files.joints_per_motor * test::BentCell::random_motors(random));
  ArmModelSize size;
  size.ripples = 2;
  size.warms = true;
  size.posture = basis_over_postures(postures, 0.6);
  size.wave = basis_over_disc(0.6, 0.2);
  size.wander = {Eigen::Matrix2Xd::Zero(2, 3), 0.4};
  size.wander.centers.row(0) << 0.5, 1.0, 2.0;
  return size;
}

TEST_CASE("The derivatives by every unknown agree with finite differences") {
  const test::BentCell cell;
  std::mt19937 random(4);
  std::normal_distribution<double> noise;
  ArmNominal files = cell.nominal();
  files.leans.sigma.setConstant(5e-6);
  std::vector<ArmModelSize> sizes{{0, true}, {1, true}, {3, true}, whole_size(random, files)};
  for (const ArmModelSize& size : sizes) {
    const ArmModel model(files, size);
    Eigen::VectorXd sigma = model.prior_sigma();
    sigma = (sigma.array() == 1.0).select(1e-5, sigma);  // the Gaussians' weights
    for (int draw = 0; draw < 20; ++draw) {
      const PosedAt pose{test::BentCell::random_motors(random), 0.7 + 0.1 * draw};
      Eigen::VectorXd x = model.nominal();
      for (Eigen::Index k = 0; k < x.size(); ++k) x[k] += sigma[k] * noise(random);
      const ArmModel::Jacobian J = model.jacobian(pose, x);
      REQUIRE(J.cols() == x.size());
      for (Eigen::Index k = 0; k < x.size(); ++k) {
        const double step = 1e-3 * std::max(sigma[k], 1e-6);
        Eigen::VectorXd more = x, less = x;
        more[k] += step;
        less[k] -= step;
        const Eigen::Matrix<double, 2, 3> slope =
            (model.at(pose, more).points - model.at(pose, less).points) / (2.0 * step);
        const Eigen::Map<const Eigen::Matrix<double, 6, 1>> expected(slope.data());
        // The lamps' height is left out of the other columns: it changes them by a thousandth.
        INFO("unknown " << k << " of " << x.size());
        CHECK((J.col(k) - expected).norm() < 5e-3 * expected.norm() + 1e-6);
      }
    }
  }
}

TEST_CASE("What an arm's warmth changes is nothing at time 0, and grows") {
  const test::BentCell cell;
  ArmModelSize size;
  size.warms = true;
  const ArmModel model(cell.nominal(), size);
  Eigen::VectorXd x = model.nominal();
  const Eigen::Vector3d motors(0.4, 1.1, -0.6);
  const auto tip_at = [&](double t_h) { return model.at({motors, t_h}, x).tip.p; };
  const Eigen::Vector2d cold = tip_at(0.0);
  x.segment<2>(model.layout().warming).setConstant(1e-4);  // a share of both links
  CHECK((tip_at(0.0) - cold).norm() == 0.0);
  CHECK((tip_at(2.0) - (1.0 + 2e-4) * cold).norm() < 1e-12);
}

}  // namespace
}  // namespace planar
