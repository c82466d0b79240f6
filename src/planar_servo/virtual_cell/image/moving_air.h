#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// The shift of image points by air in the light's path: waves over the picture, whose amplitudes
/// are Ornstein-Uhlenbeck processes. It depends on seed and time alone, whatever was asked before.
class MovingAir {
 public:
  MovingAir(const AirTruth& truth, std::uint64_t seed);

  Eigen::Vector2d shift_px(const Eigen::Vector2d& w_px, double t_s) const;

  /// Returns a time in which the air hardly moves.
  double still_s() const;

 private:
  struct Wave {
    Eigen::Vector2d per_px;  ///< radians
    double phase_rad;
  };
  using Amplitudes = Eigen::Matrix2Xd;  ///< one column per wave, of standard deviation 1

  Amplitudes at_step(std::int64_t step) const;
  const Amplitudes& amplitudes(double t_s) const;

  AirTruth truth_;
  std::uint64_t seed_;
  std::vector<Wave> waves_;
  mutable std::optional<double> asked_s_;  ///< the time of `asked_`
  mutable Amplitudes asked_;
};

}  // namespace planar
