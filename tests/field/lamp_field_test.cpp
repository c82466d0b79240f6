#include "planar_servo/learn/field/lamp_field.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"

namespace planar {
namespace {

/// A tracker whose readings have nothing in common, as those of a BentCell.
ArmNominal without_bias(ArmNominal nominal) {
  nominal.registration_shift = nominal.registration_turn = nominal.tracker_bias = 1e-12;
  return nominal;
}

TEST_CASE("The stated interval holds the true end point about as often as it says") {
  const test::BentCell cell;
  int covered = 0, all = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::mt19937 random(seed);
    const std::vector<PoseSample> samples = cell.samples(100, 0, random);
    JointEstimate estimate;
    estimate.nominal = without_bias(cell.nominal());
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

TEST_CASE("What all readings may have in common enters the stated uncertainty of every place") {
  const test::BentCell cell;
  std::mt19937 random(7);
  const std::vector<PoseSample> samples = cell.samples(100, 0, random);
  const auto sigma_at = [&](const ArmNominal& nominal, std::size_t i) {
    JointEstimate estimate;
    estimate.nominal = nominal;
    estimate.fit = fit_jointly(estimate.model(), {}, samples, 0.6).value();
    return std::sqrt(
        compensate(lamp_field(estimate, samples), samples[i].lamps_B).covariance(0, 0));
  };
  const ArmNominal unbiased = without_bias(cell.nominal());
  ArmNominal shifted = unbiased, biased = unbiased;
  shifted.registration_shift = 20e-6;
  biased.tracker_bias = 20e-6;
  for (const std::size_t i : {0u, 50u}) {
    const double sigma = sigma_at(unbiased, i);
    CHECK(sigma < 5e-6);
    CHECK(sigma_at(biased, i) > sigma + 1e-6);
    CHECK(sigma_at(shifted, i) > sigma);
  }
}

TEST_CASE(
    "The kept part of the covariance states what the whole one does of sight and of landing") {
  const test::BentCell cell;
  std::mt19937 random(8);
  const std::vector<PoseSample> samples = cell.samples(80, 40, random);
  JointEstimate estimate;
  estimate.nominal = cell.nominal();
  JointPriors priors;
  priors.arm_sigma = 3e-6;
  estimate.fit = fit_jointly(estimate.model(), priors, samples, 0.6).value();
  const FieldAndArm found = field_and_arm(estimate, samples);
  REQUIRE(found.field.factor.cols() == found.arm.factor.cols());
  CHECK(found.field.factor.cols() < found.field.unknowns());
  const Eigen::Index arms = found.arm.form.terms();
  const Eigen::MatrixXd whole = estimate.fit.covariance.block(
      2 * estimate.fit.field_terms(), 2 * estimate.fit.field_terms(), arms, arms);
  const LampField field = lamp_field(estimate, samples);
  for (const PoseSample& sample : samples) {
    const Eigen::MatrixXd J = found.arm.form.jacobian(sample.motors, found.arm.x).topRows<2>();
    const Eigen::Vector2d landing = (J * whole * J.transpose()).diagonal().cwiseSqrt(),
                          kept = (J * found.arm.factor).rowwise().norm();
    const Eigen::Vector2d sight =
        compensate(field, sample.lamps_B).covariance.diagonal().cwiseSqrt();
    const Eigen::Vector2d kept_sight =
        compensate(found.field, sample.lamps_B).covariance.diagonal().cwiseSqrt();
    CHECK((kept - landing).cwiseQuotient(landing).cwiseAbs().maxCoeff() < 0.02);
    CHECK((kept_sight - sight).cwiseQuotient(sight).cwiseAbs().maxCoeff() < 0.02);
  }
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
