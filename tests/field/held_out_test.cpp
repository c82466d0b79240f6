#include "planar_servo/learn/field/held_out.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"
#include "planar_servo/learn/field/fit_lamp_field.h"

namespace planar {
namespace {

TEST_CASE("Places left out are met within what the fit says, and far better than by raw vision") {
  const test::BentCell cell;
  std::mt19937 random(31);
  const auto samples = cell.samples(80, 60, random);
  const JointEstimate estimate = estimate_jointly(cell.nominal(), samples);
  const HeldOut judged = hold_out(estimate, samples);
  CHECK(judged.n == 80);
  CHECK(judged.raw_rms > 0.05e-3);
  // Two axes of a reading's noise and little more.
  CHECK(judged.rms == Approx(std::sqrt(2.0) * cell.noise_reflector).epsilon(0.25));
  CHECK(judged.coverage_95 == Approx(0.95).margin(0.05));
  CHECK(judged.worth_using());
}

TEST_CASE("What the camera drifted since a reading is no miss of a place that was left out") {
  const test::BentCell cell;
  std::mt19937 random(34);
  auto samples = cell.samples(80, 60, random);
  const Eigen::Vector2d drift_m_per_h(60e-6, -30e-6);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].t_h = -static_cast<double>((37 * i) % 140) / 140.0;
    for (Eigen::Vector2d& lamp : samples[i].lamps_B) lamp += samples[i].t_h * drift_m_per_h;
  }
  const HeldOut judged = hold_out(estimate_jointly(cell.nominal(), samples), samples);
  CHECK(judged.rms == Approx(std::sqrt(2.0) * cell.noise_reflector).epsilon(0.25));
}

TEST_CASE("Air that moves pictures of both lamps is in what is stated of places left out") {
  test::BentCell cell;
  cell.noise_reflector = 3e-6;
  std::mt19937 random(35);
  JointEstimate estimate;
  estimate.nominal = cell.nominal();
  estimate.priors.air_sigma = 10e-6;
  std::normal_distribution<double> air(0.0, estimate.priors.air_sigma);
  auto samples = cell.samples(120, 0, random);
  for (PoseSample& sample : samples) {
    const Eigen::Vector2d moved{air(random), air(random)};
    for (Eigen::Vector2d& lamp : sample.lamps_B) lamp += moved;
  }
  estimate.fit = fit_jointly(estimate.model(), estimate.priors, samples, 0.6).value();
  CHECK(hold_out(estimate, samples).coverage_95 == Approx(0.95).margin(0.06));
}

TEST_CASE("The lamps' noise turns a reflector far from the end point, as is stated") {
  test::BentCell cell;
  cell.noise_reflector = 3e-6;
  cell.noise_lamp = 5e-6;
  cell.reflector_T = {0.12, 0.0};
  std::mt19937 random(36);
  JointEstimate estimate;
  estimate.nominal = cell.nominal();
  estimate.nominal.tool.p_TS.head<2>() = cell.reflector_T;
  const auto samples = cell.samples(120, 0, random);
  estimate.fit = fit_jointly(estimate.model(), estimate.priors, samples, 0.6).value();
  CHECK(hold_out(estimate, samples).coverage_95 == Approx(0.95).margin(0.06));
}

TEST_CASE("Readings of one place leave together") {
  // Four readings at each of 25 places share an error of their place.
  const test::BentCell cell;
  std::mt19937 random(32);
  std::normal_distribution<double> of_place(0.0, 30e-6);
  std::vector<PoseSample> samples;
  for (int place = 0; place < 25; ++place) {
    const Eigen::Vector3d motors = test::BentCell::random_motors(random);
    const Eigen::Vector2d shift{of_place(random), of_place(random)};
    for (int i = 0; i < 4; ++i) {
      samples.push_back(cell.sample(motors, true, random));
      *samples.back().reflector_B += shift;
      samples.back().place = "place " + std::to_string(place);
    }
  }
  JointEstimate estimate;
  estimate.nominal = cell.nominal();
  estimate.fit = fit_jointly(estimate.model(), {}, samples, 0.6).value();
  const double together = hold_out(estimate, samples).rms;
  for (PoseSample& sample : samples) sample.place.clear();
  CHECK(together > 1.2 * hold_out(estimate, samples).rms);
}

TEST_CASE("Without readings nothing is judged, and the arm alone fixes scale and datum") {
  const test::BentCell cell;
  std::mt19937 random(33);
  const LampFieldFit fit = fit_lamp_field(cell.nominal(), cell.samples(0, 60, random));
  CHECK(fit.held_out.n == 0);
  CHECK_FALSE(fit.held_out.worth_using());
  CHECK(fit.n_unattended == 60);
  const JointPriors& priors = fit.estimate.priors;
  CHECK(fit.noise_sigma == Approx(std::hypot(priors.lamp_factor * cell.noise_lamp / std::sqrt(2.0),
                                             priors.air_sigma)));
  CHECK(fit.fixed_by.scale == FieldSource::kArm);
  CHECK(fit.fixed_by.turn == FieldSource::kNothing);
}

}  // namespace
}  // namespace planar
