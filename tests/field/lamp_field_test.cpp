#include "planar_servo/field/lamp_field.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"

namespace planar {
namespace {

TEST_CASE("The stated interval holds the true end point about as often as it says") {
  const test::BentCell cell;
  int covered = 0, all = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::mt19937 random(seed);
    const std::vector<PoseSample> samples = cell.samples(100, 0, random);
    JointEstimate estimate;
    estimate.nominal = cell.nominal();
    estimate.fit = fit_jointly(estimate.model(), {}, samples, 0.6).value();
    const LampField field = lamp_field(estimate, samples);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d motors = test::BentCell::random_motors(random);
      const PoseSample seen = cell.sample(motors, false, random);
      const CompensatedTip found = compensate(field, seen.lamps_B);
      if (!found.inside) continue;
      const Eigen::Vector2d off = found.tip.p - cell.truth(motors).tip;
      const double lamps = 0.5 * cell.noise_lamp * cell.noise_lamp;
      for (int axis = 0; axis < 2; ++axis)
        covered += std::abs(off[axis]) < 1.96 * std::sqrt(found.covariance(axis, axis) + lamps);
      all += 2;
    }
  }
  CHECK(all > 1000);
  CHECK(static_cast<double>(covered) / all > 0.88);
  CHECK(static_cast<double>(covered) / all < 0.99);
}

TEST_CASE("A field of nothing leaves the lamps where they are seen") {
  LampField field;
  field.basis = basis_over_disc(0.6, 0.2);
  field.weights.setZero(field.basis.terms(), 2);
  field.factor.setZero(2 * field.basis.terms() + 5, 2 * field.basis.terms() + 5);
  field.tool.p_TP = {-0.003, 0.002};
  const CompensatedTip found =
      compensate(field, {Eigen::Vector2d(0.3, 0.1), Eigen::Vector2d(0.3, 0.14)});
  CHECK(found.tip.phi == Approx(kPi / 2.0));
  CHECK((found.tip.p - Eigen::Vector2d(0.298, 0.117)).norm() < 1e-15);
  CHECK(found.covariance.norm() == 0.0);
  CHECK_FALSE(found.inside);
}

TEST_CASE("An error of one lamp alone turns the tool back") {
  LampField field;
  field.basis = basis_over_disc(0.6, 0.2);
  field.weights.setZero(field.basis.terms(), 2);
  const Eigen::Index linear_y = field.basis.centers.cols() + 2;
  field.weights(linear_y, 0) = 0.6e-3;  // e_x = 1e-3 y
  field.factor.setZero(2 * field.basis.terms() + 5, 2 * field.basis.terms() + 5);
  const CompensatedTip found =
      compensate(field, {Eigen::Vector2d(0.3, 0.0), Eigen::Vector2d(0.3 + 0.04e-3, 0.04)});
  CHECK(found.tip.phi == Approx(kPi / 2.0));
  CHECK(found.tip.p.x() == Approx(0.3));
}

}  // namespace
}  // namespace planar
