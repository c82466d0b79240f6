#include "planar_servo/learn/field/joint_estimate.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "field/bent_cell.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/learn/field/fit_lamp_field.h"
#include "planar_servo/learn/field/lamp_field.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("As many harmonics are found as the reducers have") {
  for (const double second : {0.0, 0.25}) {
    test::BentCell cell;
    cell.second = second;
    std::mt19937 random(3);
    const JointEstimate found = estimate_jointly(cell.nominal(), cell.samples(60, 0, random));
    CHECK(found.size.harmonics == (second > 0.0 ? 2 : 1));
    CHECK(found.size.ripples == 0);
    CHECK(found.left_out.empty());
    CHECK(found.fit.arm[0] == Approx(cell.link1).margin(20e-6));
    CHECK(found.fit.arm[1] == Approx(cell.link2).margin(20e-6));
    const double sigma = std::sqrt(found.fit.covariance.diagonal()[2 * found.fit.field_terms()]);
    CHECK(std::abs(found.fit.arm[0] - cell.link1) < 4.0 * sigma);
  }
}

TEST_CASE("Ripple of the motors' own turns is found") {
  test::BentCell cell;
  cell.ripple = 0.3e-3;
  std::mt19937 random(13);
  const JointEstimate found = estimate_jointly(cell.nominal(), cell.samples(100, 0, random));
  REQUIRE(found.size.ripples == 2);
  const Eigen::Index first = ArmForm::kFirstWave + Eigen::Index{6} * found.size.harmonics;
  for (int motor = 0; motor < 2; ++motor)
    CHECK(std::hypot(found.fit.arm[first + motor], found.fit.arm[first + 3 + motor]) ==
          Approx(cell.ripple).epsilon(0.1));
}

/// Returns the mean distance from the compensated end point to the true one at other places.
double mean_miss_m(const test::BentCell& cell, const JointEstimate& estimate,
                   const std::vector<PoseSample>& samples) {
  const LampField field = lamp_field(estimate, samples);
  std::mt19937 random(99);
  test::BentCell still = cell;
  still.scatter = 0.0;
  constexpr int kPlaces = 300;
  double sum = 0.0;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector3d motors = test::BentCell::random_motors(random);
    const PoseSample seen = still.sample(motors, false, random);
    sum += (compensate(field, seen.lamps_B).tip.p - still.truth(motors).tip).norm() / kPlaces;
  }
  return sum;
}

TEST_CASE("How far an arm scatters is found, and the field is better for it") {
  test::BentCell cell;
  cell.scatter = 20e-6;
  std::mt19937 random(14);
  const std::vector<PoseSample> samples = cell.samples(60, 120, random);
  JointEstimate estimate = estimate_jointly(cell.nominal(), samples);
  CHECK(estimate.priors.arm_sigma == Approx(cell.scatter).epsilon(0.3));
  CHECK(estimate.arm().scatter_m == estimate.priors.arm_sigma);
  const double knowing_m = mean_miss_m(cell, estimate, samples);
  JointPriors held = estimate.priors;
  held.arm_sigma = 5e-6;
  estimate.fit = fit_jointly(estimate.model(), held, samples, estimate.fit.basis.radius).value();
  CHECK(knowing_m < mean_miss_m(cell, estimate, samples));
  CHECK(knowing_m < 10e-6);
}

TEST_CASE("Priors are searched for until the samples are as likely as under the true ones") {
  test::BentCell cell;
  cell.scatter = 16e-6;
  cell.wave = 80e-6;
  std::mt19937 random(15);
  const LaidDots board = cell.lays(6, 3.0, 0.0, random);
  const std::vector<PoseSample> samples = cell.samples(0, 120, random);
  const JointEstimate found = estimate_jointly(cell.nominal(), samples, board);
  REQUIRE(found.left_out.empty());
  JointPriors truth = found.priors;
  truth.arm_sigma = cell.scatter;
  truth.wave_sigma = 0.5 * cell.wave;
  truth.lamp_factor = 1.0;
  truth.air_sigma = truth.tool_sigma = truth.deviation_sigma = 1e-8;
  const auto under_truth =
      fit_jointly(found.model(), truth, samples, found.fit.basis.radius, board);
  REQUIRE(under_truth);
  CHECK(found.fit.log_likelihood > under_truth->log_likelihood - 1.0);
  CHECK(found.priors.wave_sigma > 0.25 * cell.wave);
}

TEST_CASE("A base that moves within minutes is neither the field's error nor the arm's scatter") {
  const test::BentCell cell;
  std::mt19937 random(31);
  std::vector<PoseSample> samples = cell.samples(150, 0, random);
  // A way from place to place: without the time nothing distinguishes the base from the field.
  std::sort(samples.begin(), samples.end(),
            [](const PoseSample& a, const PoseSample& b) { return a.motors[0] < b.motors[0]; });
  constexpr double kPeriod_h = 0.3, kLargest_m = 10e-6;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].t_h = 1.5 * (static_cast<double>(i + 1) / static_cast<double>(samples.size()) - 1.0);
    const double turns = samples[i].t_h / kPeriod_h;
    const double triangle = 4.0 * std::abs(turns - std::round(turns)) - 1.0;
    const Eigen::Vector2d base = kLargest_m * triangle * Eigen::Vector2d(0.8, 0.6);
    *samples[i].reflector_B += base;
    for (Eigen::Vector2d& lamp : samples[i].lamps_B) lamp += base;
  }
  JointEstimate estimate = estimate_jointly(cell.nominal(), samples);
  CHECK(estimate.arm().wander_m == Approx(kLargest_m / std::sqrt(6.0)).epsilon(0.6));
  CHECK(estimate.priors.arm_sigma < 2e-6);
  const double knowing_m = mean_miss_m(cell, estimate, samples);
  estimate.size.wander = {{}, 1.0};
  estimate.fit =
      fit_jointly(estimate.model(), estimate.priors, samples, estimate.fit.basis.radius).value();
  CHECK(knowing_m < 0.7 * mean_miss_m(cell, estimate, samples));
}

TEST_CASE("A wrong reading leaves without its pose, a wrong lamp takes the pose with it") {
  for (const unsigned seed : {8u, 9u, 10u, 11u}) {
    const test::BentCell cell;
    std::mt19937 random(seed);
    std::vector<PoseSample> samples = cell.samples(60, 0, random);
    samples[7].reflector_B->x() += 0.2e-3;
    samples[11].lamps_B[1].y() += 0.1e-3;
    const JointEstimate found = estimate_jointly(cell.nominal(), samples);
    INFO("seed " << seed);
    CHECK(found.left_out.size() >= 3);
    CHECK(found.left_out.size() <= 4);  // a sound reading may leave with them
    int readings_of_7 = 0, of_11 = 0;
    for (const JointOutlier& outlier : found.left_out) {
      readings_of_7 += outlier.index == 7 && outlier.reading ? 1 : 0;
      of_11 += outlier.index == 11 ? 1 : 0;
    }
    CHECK(readings_of_7 == 1);
    CHECK(of_11 == 2);
  }
}

TEST_CASE("Two outliers in a hundred are left out, and hardly a sound pose with them") {
  const test::BentCell cell;
  std::mt19937 random(21);
  std::vector<PoseSample> samples = cell.samples(100, 300, random);
  for (std::size_t i = 25; i < samples.size(); i += 50) {
    const double size = i % 100 == 25 ? 3e-3 : 0.15e-3;
    if (i < 100)
      samples[i].reflector_B->y() -= size;
    else
      samples[i].lamps_B[0].x() += size;
  }
  const JointEstimate found = estimate_jointly(cell.nominal(), samples);
  std::set<std::size_t> out;
  for (const JointOutlier& outlier : found.left_out) out.insert(outlier.index);
  CHECK(out == std::set<std::size_t>{25, 75, 125, 175, 225, 275, 325, 375});
}

TEST_CASE("Of few poses whose scatter has long tails hardly any is left out") {
  for (const unsigned seed : {31u, 32u, 33u, 34u, 35u}) {
    INFO("seed " << seed);
    test::BentCell cell;
    std::mt19937 random(seed);
    cell.scatter = 2e-6;
    std::vector<PoseSample> samples = cell.samples(42, 0, random);
    cell.scatter = 12e-6;
    const std::vector<PoseSample> wider = cell.samples(42, 0, random);
    for (std::size_t i = 0; i < samples.size(); i += 4) samples[i] = wider[i];
    CHECK(estimate_jointly(cell.nominal(), samples).contradicting < 0.03);
  }
}

TEST_CASE("A map of poses of which a quarter disagrees with the others is objected to") {
  const test::BentCell cell;
  std::mt19937 random(22);
  std::vector<PoseSample> samples = cell.samples(80, 0, random);
  for (std::size_t i = 0; i < samples.size(); i += 4) samples[i].reflector_B->x() += 2e-3;
  const JointEstimate found = estimate_jointly(cell.nominal(), samples);
  CHECK(found.contradicting > kMostContradicting);
  CHECK_THAT(InputError(objection(fit_lamp_field(cell.nominal(), samples).quality()).value()),
             Refused(Cause::kContradiction, "of its poses"));
}

TEST_CASE("A pose without a standard deviation, or with a value that is none, is named") {
  const test::BentCell cell;
  std::mt19937 random(23);
  std::vector<PoseSample> samples = cell.samples(20, 0, random);
  samples[3].sigma_lamp = 0.0;
  CHECK_THROWS_MATCHES(estimate_jointly(cell.nominal(), samples), InputError,
                       Refused(Cause::kInvalid, "'p4'"));
  samples[3] = samples[2];
  samples[6].motors[1] = std::nan("");
  CHECK_THROWS_MATCHES(estimate_jointly(cell.nominal(), samples), InputError,
                       Refused(Cause::kInvalid, "'p7'"));
}

TEST_CASE("Too few poses are refused") {
  const test::BentCell cell;
  std::mt19937 random(9);
  std::vector<PoseSample> samples = cell.samples(40, 0, random);
  CHECK_THROWS_MATCHES(estimate_jointly(cell.nominal(), {samples.begin(), samples.begin() + 11}),
                       InputError, Refused(Cause::kInsufficient, "11 poses"));
}

}  // namespace
}  // namespace planar
