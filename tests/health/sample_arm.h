#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/health/health_check.h"

namespace planar::test {

/// The coupling of motors 2 and 3 that each ride on the link before them, or not.
inline Eigen::Matrix3d coupling_of(bool second_rides, bool third_rides) {
  Eigen::Matrix3d C = Eigen::Matrix3d::Identity();
  if (second_rides) C(1, 0) = -1.0;
  if (third_rides) C(2, 1) = -1.0;
  return C;
}

/// A cell as its files say.
inline CellModel filed_cell() {
  CellModel model;
  model.coupling = coupling_of(true, true);
  model.links_m = {0.3, 0.25};
  model.lamps_T = {Eigen::Vector2d(-0.02, 1e-4), Eigen::Vector2d(0.02, 0.0)};
  model.axis_B = {5e-3, -3e-3};
  model.home = {0.1, 0.9, -1.0};
  model.pulses_per_rad = {150e3, -120e3, 100e3};
  return model;
}

/// Draws a sound cell: off from its files by what is usual, with eccentric reducers.
class SoundCell {
 public:
  explicit SoundCell(unsigned seed) : random_(seed) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      model.zeros[i] = normal(0.12 * kDegree);
      phases_[i] = uniform(-kPi, kPi);
    }
    for (Eigen::Index i = 0; i < 2; ++i) model.links_m[i] += uniform(-1e-3, 1e-3);
  }

  CellModel model = filed_cell();
  Numbers off = Numbers::Zero();  ///< what a test makes wrong beyond that

  /// Returns where the lamps are seen, each coordinate with noise of this standard deviation.
  LampPlaces see(const Eigen::Vector3d& commanded, double noise_m) {
    Eigen::Vector3d motors = commanded;
    for (Eigen::Index i = 0; i < 3; ++i)
      motors[i] += 0.03 * kDegree * std::sin(commanded[i] + phases_[i]) +
                   0.01 * kDegree * std::sin(2.0 * commanded[i] - phases_[i]);
    LampPlaces lamps = lamps_seen(model, motors, off);
    for (Eigen::Vector2d& lamp : lamps) lamp += Eigen::Vector2d(normal(noise_m), normal(noise_m));
    return lamps;
  }

  double normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(random_); }
  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }

 private:
  std::mt19937 random_;
  std::array<double, 3> phases_{};
};

}  // namespace planar::test
