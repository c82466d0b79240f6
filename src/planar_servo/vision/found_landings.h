#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "planar_servo/arm/arm_learner.h"
#include "planar_servo/arm/following_error.h"
#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/field/lamp_field.h"
#include "planar_servo/servo/landing_model.h"

namespace planar {

/// Tells a change of the view from an arm that strays: a drop on the window displaces one lamp by
/// more than the other, an arm moves both. It compares a look's distance between the lamps and the
/// tool's direction, from that of the command, with those at the recent targets.
class LampAgreement {
 public:
  /// Takes a first look that nothing is wrong with: the lamps' distance, compensated, metres, and
  /// by how much the tool is turned from its command, radians.
  void take(double separation_m, double turn);

  /// Returns whether enough looks were taken to compare others with.
  bool knows() const { return turns_.size() >= kFewest; }
  /// Returns whether it is known that a look is as the recent ones were.
  bool agrees(double separation_m, double turn) const;

  static constexpr std::size_t kWindow = 40, kFewest = 5;

 private:
  std::deque<double> separations_m_, turns_;
};

/// The landings of an arm that was found together with the field of its camera. What is known of
/// both has one covariance. All looks of a run tell whether arm and view still are as they were
/// found together.
class FoundLandings : public LandingModel {
 public:
  /// Takes field and arm, and how far an arm that strayed may be off, per axis. Throws
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
  /// Returns the rows by which vision, compensated by the field, is wrong at a look.
  Eigen::Matrix2Xd vision_rows(const TipMeasurement& look) const;
  /// Returns a look that the guard let through as it speaks of the arm.
  ArmLook arm_look(const SeenLanding& seen) const;
  /// Returns whether the arm as it was found is likely to be seen so.
  bool explains(const SeenLanding& seen) const { return following_.explains(arm_look(seen)); }
  /// Returns the prior of an arm whose stops scatter by so much, per axis.
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

/// The landings of such an arm where it is learned further from the first look at every target. The
/// field stays as it was found.
class LearningLandings final : public FoundLandings {
 public:
  /// Takes what FoundLandings takes, and what is known of the arm by now.
  LearningLandings(LampField field, const FoundArm& found, LearnedArm known,
                   const Transmission& transmission, double stray_m);

  LandingPrior at(const Joints& theta_c, const TipMeasurement& look) const override;
  void learn(const SeenLanding& seen) override;
  const FoundArm* learned_arm() const override { return &learner_.learned().arm; }

  const ArmLearner& learner() const { return learner_; }

 private:
  /// Takes back what was learned where the arm as it was found explains a look that it does not.
  void unlearn(const SeenLanding& seen);

  ArmLearner learner_;
  bool has_warned_{false};  ///< of looks beyond the caps
};

}  // namespace planar
