#include "planar_servo/certificate/cell_accuracy.h"

#include <catch2/catch.hpp>
#include <random>

namespace planar {
namespace {

CycleErrors everywhere(const Eigen::Vector2d& error) {
  CycleErrors errors;
  errors.fill(error);
  return errors;
}

/// Cycles with noise of 1 um per axis and an even drift along x.
std::vector<CycleErrors> drifting(int cycles, double um_per_cycle) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0.0, 1e-6);
  std::vector<CycleErrors> all;
  for (int i = 0; i < cycles; ++i) {
    CycleErrors errors = everywhere({5e-6 + um_per_cycle * 1e-6 * i, 0.0});
    for (Eigen::Vector2d& error : errors) {
      error.x() += noise(random);
      error.y() += noise(random);
    }
    all.push_back(errors);
  }
  return all;
}

TEST_CASE("The first third is compared with the last") {
  std::vector<CycleErrors> cycles;
  for (int i = 0; i < 9; ++i) cycles.push_back(everywhere({3e-6 * i, 4e-6 * i}));
  const PoseDrift drift = pose_drift(cycles).value();
  CHECK(drift.cycles == 3);
  CHECK(drift.shift == Approx(30e-6));  // from cycle 1 to cycle 7, 5 um a cycle
  CHECK(drift.accuracy.first == Approx(5e-6));
  CHECK(drift.accuracy.last == Approx(35e-6));
  CHECK(drift.repeatability.value().first == Approx(drift.repeatability->last));
}

TEST_CASE("A drift stands out of the noise, and noise alone does not") {
  const PoseDrift still = pose_drift(drifting(30, 0.0)).value();
  CHECK(still.shift < still.shift_chance);
  CHECK(std::abs(still.accuracy.last - still.accuracy.first) < still.accuracy.chance);
  // Means of ten cycles at five poses: 1.96 sqrt(2 / 50) um and a little more in two axes.
  CHECK(still.shift_chance == Approx(0.49e-6).margin(0.15e-6));
  const PoseDrift drift = pose_drift(drifting(30, 0.05)).value();
  CHECK(drift.shift == Approx(1e-6).margin(0.4e-6));
  CHECK(drift.shift > drift.shift_chance);
  CHECK(drift.accuracy.last - drift.accuracy.first > drift.accuracy.chance);
}

TEST_CASE("Few cycles tell of a shift, fewer of none") {
  const PoseDrift drift =
      pose_drift({everywhere({0.0, 0.0}), everywhere({9.0, 9.0}), everywhere({3.0, 4.0})}).value();
  CHECK(drift.cycles == 1);
  CHECK(drift.shift == Approx(5.0));
  CHECK_FALSE(drift.repeatability);
  CHECK_FALSE(pose_drift({everywhere({1.0, 0.0})}));
}

}  // namespace
}  // namespace planar
