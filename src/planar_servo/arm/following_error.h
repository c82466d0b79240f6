#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "planar_servo/arm/arm_learner.h"
#include "planar_servo/core/error.h"

namespace planar {

/// Judges by the first looks at the recent targets whether an arm still lands where it was found
/// to, as controls judge following error. The looks share the uncertainty of arm and vision and the
/// change of the arm by the motors' warmth; each has its own scatter. The remainder is fitted with
/// a shift, its growth in time, a turn and a stretch.
class FollowingError {
 public:
  /// Takes the arm as it was found, whatever was learned since.
  explicit FollowingError(FoundArm found);

  void take(const ArmLook& look, double t_s);

  /// Returns whether the arm as it was found, a little warmer or colder, is likely to be seen so.
  bool explains(const ArmLook& look) const;

  /// Returns what shows that arm or camera has moved; empty while what is known of them explains
  /// the looks, or while they differ by less than kTolerated_m.
  std::optional<Refusal> doubt() const;

  static constexpr std::size_t kWindow = 20, kFewest = 5;  ///< targets
  /// A smaller difference is not worth stopping for.
  static constexpr double kTolerated_m = 50e-6;

 private:
  struct Look {
    double t_s{0.0};
    Eigen::Vector2d p{0.0, 0.0};    ///< where the arm should have landed
    Eigen::Vector2d off{0.0, 0.0};  ///< where it was seen, from there
    Eigen::Matrix2Xd rows;          ///< of what all looks share, times numbers of unit variance
    double sigma_m{0.0};
  };
  Look look_at(const ArmLook& look, double t_s) const;
  Eigen::MatrixXd patterns() const;

  FoundArm found_;
  Eigen::MatrixXd warmth_;  ///< of the arm's terms, deviations in an hour
  std::deque<Look> looks_;
};

}  // namespace planar
