#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// The shift of image points by air in the light's path: waves over the picture, whose amplitudes
/// are Ornstein-Uhlenbeck processes. It depends on seed and time alone, not on earlier calls.
class MovingAir {
 public:
  MovingAir(const AirTruth& truth, std::uint64_t seed);

  Eigen::Vector2d shift_px(const Eigen::Vector2d& w_px, double t_s) const;

  /// Returns a time within which the air hardly moves.
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

/// Projects points as the true camera does; see CameraTruth.
class VirtualLens {
 public:
  /// The seed is that of the air before the lens.
  explicit VirtualLens(const CameraTruth& truth, std::uint64_t seed = 0);

  /// Returns the pixel of a point of the base frame at the time `t_s`; empty when the point is
  /// behind the camera or beyond the lens's reach.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_B, double t_s) const;

  /// Inverts ideal_from_distorted() by Newton's method; empty when that does not converge.
  std::optional<Eigen::Vector2d> distorted_from_ideal(const Eigen::Vector2d& ideal) const;
  Eigen::Vector2d ideal_from_distorted(const Eigen::Vector2d& distorted) const;

  Eigen::Vector2d warp_px(const Eigen::Vector2d& w_px) const;

  /// Returns the camera's centre in the base frame, metres.
  const Eigen::Vector3d& p_BC() const { return p_BC_; }

  /// Returns a time within which the image moves by less than 0.001 px.
  double still_s() const;

 private:
  Eigen::Vector2d warmed_px(const Eigen::Vector2d& w_px, const WarmingTruth& warming,
                            double t_s) const;

  CameraTruth truth_;
  Eigen::Vector3d p_BC_;
  std::optional<MovingAir> air_;
};

}  // namespace planar
