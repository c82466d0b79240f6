#pragma once

#include <Eigen/Core>

namespace planar {

/// Holds one look at a landing. Base frame, metres; deviations are per axis.
struct LandingLook {
  Eigen::Vector2d p_c{0.0, 0.0};  ///< where the arm, as it was found, should bring the end point
  Eigen::Vector2d p{0.0, 0.0};    ///< where vision, compensated, sees it
  double noise_m{0.0};            ///< of this look alone
  double scatter_m{0.0};          ///< of this stop alone
};

/// Holds an estimate of a point or a vector in the plane.
struct PlaneEstimate {
  Eigen::Vector2d mean{0.0, 0.0};
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
};

/// Holds by how much a look differs from what the looks before it let expect.
struct Innovation {
  Eigen::Vector2d value{0.0, 0.0};
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};

  double chi_squared() const;
  double log_likelihood() const;
};

/// Says how far, per axis, the places that looks let expect scatter about the target: after the
/// next correction, and after those behind it, when one look more has told what can be told.
struct Spread {
  double next_m{0.0}, later_m{0.0};
};

/// Estimates where the end point lands at one target, from all looks at it. Stop k lands at
///   l_k = c_k + d + s_k    and is seen at    z_k = l_k + v + n_k
/// with the place c_k that was commanded, the arm's persistent error d, the scatter s_k of this
/// stop, the error v that all looks have in common, and the noise n_k of this one. It is a Kalman
/// filter of (d, v), in which d changes a little with every correction.
class LandingFilter {
 public:
  /// Takes the covariance of (d, v), whose mean is zero.
  explicit LandingFilter(const Eigen::Matrix4d& covariance) : covariance_(covariance) {}

  /// Returns what a look would bring that is new.
  Innovation innovation(const LandingLook& look) const;

  void take(const LandingLook& look);

  /// Returns where the last look's stop landed. Valid after the first look.
  const PlaneEstimate& landing() const { return landing_; }
  /// Returns d.
  PlaneEstimate persistent_error() const;
  /// Returns the place to command so that the next stop is expected to land at the target.
  Eigen::Vector2d next_command(const Eigen::Vector2d& p_d) const { return p_d - mean_.head<2>(); }

  /// Returns by how much the places that further looks will let expect scatter about the target:
  /// the part of the landings' deviation that looking can reveal. `next` is the next look as far as
  /// it is known now, without where the end point is seen.
  Spread spread(const LandingLook& next) const;

 private:
  /// Returns the covariance of (d, v) once the arm has been sent to p_c.
  Eigen::Matrix4d covariance_at(const Eigen::Vector2d& p_c) const;
  double revealed_m(const LandingLook& next) const;

  Eigen::Vector4d mean_{Eigen::Vector4d::Zero()};
  Eigen::Matrix4d covariance_;
  PlaneEstimate landing_;
  Eigen::Vector2d p_c_{0.0, 0.0};  ///< of the last look
  bool has_looked_{false};
};

/// Returns the mean distance from the target at which somebody ends who stops when it is best, with
/// so many corrections left (at least 1). Each leads to a new place, and the old one does not come
/// back.
double nearest_expected_m(const Spread& spread, int corrections);

}  // namespace planar
