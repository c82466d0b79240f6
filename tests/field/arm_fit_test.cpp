#include "planar_servo/learn/field/arm/arm_fit.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"
#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

std::vector<ArmReading> readings_of(const test::BentCell& cell, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<ArmReading> readings;
  for (const PoseSample& sample : cell.samples(count, 0, random))
    readings.push_back({sample.id, "", sample.motors, *sample.reflector_B, sample.sigma_reflector});
  return readings;
}

TEST_CASE("A tracker's readings alone find the arm, and meet it where they were left out") {
  const test::BentCell cell;
  const ArmFit fit = fit_arm(cell.nominal(), readings_of(cell, 120, 51));
  CHECK(fit.estimate.size.harmonics == 2);
  CHECK(fit.left_out.empty());
  const Eigen::VectorXd sigma =
      fit.estimate.fit.covariance.diagonal().tail(fit.estimate.model().terms()).cwiseSqrt();
  CHECK(std::abs(fit.estimate.fit.arm[0] - cell.link1) < 4.0 * sigma[0]);
  CHECK(std::abs(fit.estimate.fit.arm[1] - cell.link2) < 4.0 * sigma[1]);
  CHECK(fit.held_out_rms == Approx(std::sqrt(2.0) * cell.noise_reflector).epsilon(0.3));
  CHECK(fit.held_out_rms > fit.rms);
}

TEST_CASE("A reflector that nobody has measured is found with the arm") {
  const test::BentCell cell;
  ArmNominal files = cell.nominal();
  files.tool.p_TS.setZero();
  files.reflector_sigma = 0.1;
  const ArmFit fit = fit_arm(files, readings_of(cell, 120, 52));
  const Eigen::Index tool = fit.estimate.model().layout().tool;
  CHECK((fit.estimate.fit.arm.segment<2>(tool + 3) - cell.reflector_T).norm() < 30e-6);
}

TEST_CASE("A reading that contradicts the arm is left out by name") {
  const test::BentCell cell;
  auto readings = readings_of(cell, 60, 53);
  readings[4].p_B.x() += 1e-3;
  const ArmFit fit = fit_arm(cell.nominal(), readings);
  REQUIRE(fit.left_out.size() == 1);
  CHECK(fit.left_out.front() == "p5");
}

TEST_CASE("Readings without a deviation, and too few of them, are refused") {
  const test::BentCell cell;
  auto readings = readings_of(cell, 20, 54);
  CHECK_THROWS_MATCHES(fit_arm(cell.nominal(), {readings.begin(), readings.begin() + 5}),
                       InputError, Refused(Cause::kInsufficient, "5 readings"));
  readings[2].sigma = 0.0;
  CHECK_THROWS_MATCHES(fit_arm(cell.nominal(), readings), InputError,
                       Refused(Cause::kInvalid, "'p3'"));
}

}  // namespace
}  // namespace planar
