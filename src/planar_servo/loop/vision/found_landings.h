#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <optional>

#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/arm/found_arm.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/learn/field/lamp_field.h"
#include "planar_servo/loop/servo/landing_estimator.h"

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

/// Distinguishes a change of the view from an arm that strays: a drop on the window displaces one
/// lamp more than the other, an arm moves both. It compares a look with those at recent targets:
/// the distance between the lamps, and how far the tool is turned from its command.
class LampAgreement {
 public:
  /// Takes a first look not in doubt: the lamps' compensated distance, metres, the turn, radians.
  void take(double separation_m, double turn);
  /// Returns whether there are enough looks to compare others with.
  bool knows() const { return turns_.size() >= kFewest; }
  /// Returns whether a look is known to be like the recent ones.
  bool agrees(double separation_m, double turn) const;

  static constexpr std::size_t kWindow = 40, kFewest = 5;

 private:
  std::deque<double> separations_m_, turns_;
};

/// The landings of an arm that was found together with the lamp field of its camera; both share one
/// covariance. The looks of a run together show whether arm and view are still as they were found.
class FoundLandings : public LandingModel {
 public:
  /// Takes field and arm, and how far off an arm that strayed may be, per axis. Throws
  /// std::invalid_argument for factors with unequal columns, which do not belong together.
  FoundLandings(LampField field, FoundArm arm, const Transmission& transmission, double stray_m);

  LandingPrior at(const Joints& theta_c, const TipMeasurement& look) const override;
  void learn(const SeenLanding& seen) override;
  std::optional<Doubt> doubt() const override;

 protected:
  const FoundArm& found() const { return found_; }
  /// Returns where the motors stand behind their gears at these joints, radians.
  Eigen::Vector3d motors(const Joints& theta_c) const {
    return transmission_.motors_from_joints(theta_c);
  }
  /// Returns the rows of the error of vision, compensated by the field, at a look.
  Eigen::Matrix2Xd vision_rows(const TipMeasurement& look) const;
  /// Returns what a look that the guard let through tells about the arm.
  ArmLook arm_look(const SeenLanding& seen) const;
  /// Returns whether the arm as found explains this landing.
  bool explains(const SeenLanding& seen) const { return following_.explains(arm_look(seen)); }
  /// Returns the prior of an arm whose stops scatter by this much, per axis.
  LandingPrior prior_of(const Eigen::Matrix4d& covariance, double scatter_m) const;

 private:
  LampField field_;
  FoundArm found_;
  Transmission transmission_;
  double stray_m_;
  FollowingError following_;
  LampAgreement lamps_;
  std::optional<Doubt> of_view_;  ///< by the last look
};

/// The landings of such an arm, learned further from the first look at every target.
class LearningLandings final : public FoundLandings {
 public:
  /// Takes what FoundLandings takes, and what has been learned of the arm so far.
  LearningLandings(LampField field, const FoundArm& found, LearnedArm known,
                   const Transmission& transmission, double stray_m);

  LandingPrior at(const Joints& theta_c, const TipMeasurement& look) const override;
  void learn(const SeenLanding& seen) override;
  const FoundArm* learned_arm() const override { return &learner_.learned().arm; }

  const ArmLearner& learner() const { return learner_; }

 private:
  /// Discards what was learned when the found arm explains a look that the learned arm does not.
  void unlearn(const SeenLanding& seen);

  ArmLearner learner_;
  bool has_warned_{false};  ///< about looks beyond the caps
  bool has_discarded_{false};
};

}  // namespace planar
