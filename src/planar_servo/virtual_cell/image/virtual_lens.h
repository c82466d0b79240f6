#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Projects points as the true camera does; see CameraTruth.
class VirtualLens {
 public:
  explicit VirtualLens(const CameraTruth& truth);

  /// Returns the pixel of a point of the base frame at the time `t_s`; empty when the point is
  /// behind the camera or beyond the lens's reach.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_B, double t_s) const;

  /// Inverts ideal_from_distorted() by Newton's method; empty when that does not converge.
  std::optional<Eigen::Vector2d> distorted_from_ideal(const Eigen::Vector2d& ideal) const;
  Eigen::Vector2d ideal_from_distorted(const Eigen::Vector2d& distorted) const;

  Eigen::Vector2d warp_px(const Eigen::Vector2d& w_px) const;

  /// Returns the camera's centre in the base frame, metres.
  const Eigen::Vector3d& p_BC() const { return p_BC_; }

 private:
  Eigen::Vector2d warmed_px(const Eigen::Vector2d& w_px, const WarmingTruth& warming,
                            double t_s) const;

  CameraTruth truth_;
  Eigen::Vector3d p_BC_;
};

}  // namespace planar
