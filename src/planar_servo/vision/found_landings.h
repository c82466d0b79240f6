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

/// Returns the rows by which vision, compensated by the field, is wrong at a look.
Eigen::Matrix2Xd vision_rows(const LampField& field, const TipMeasurement& look);

/// Returns a look that the guard let through as it speaks of the arm.
ArmLook arm_look(const SeenLanding& seen, const LampField& field, const Transmission& transmission);

/// Watches by all looks of a run whether arm and view still are as they were found together.
class LookWatch {
 public:
  LookWatch(LampField field, FoundArm found, const Transmission& transmission);

  void take(const SeenLanding& seen);

  std::optional<Doubt> doubt() const;
  /// Returns whether the arm as it was found is likely to be seen so.
  bool explains(const SeenLanding& seen) const;

 private:
  LampField field_;
  FoundArm found_;
  Transmission transmission_;
  FollowingError following_;
  LampAgreement lamps_;
  std::optional<Doubt> of_view_;  ///< by the last look
};

/// The landings of an arm that was found together with the field of its camera. What is known of
/// both has one covariance.
class FoundLandings final : public LandingModel {
 public:
  /// Takes field and arm, which have the same columns in their factors, and how far an arm that
  /// strayed may be off, per axis.
  FoundLandings(LampField field, FoundArm arm, const Transmission& transmission, double stray_m);

  LandingPrior at(const Joints& theta_c, const TipMeasurement& look) const override;
  void learn(const SeenLanding& seen) override { watch_.take(seen); }
  std::optional<Doubt> doubt() const override { return watch_.doubt(); }

 private:
  LampField field_;
  FoundArm arm_;
  Transmission transmission_;
  double stray_m_;
  LookWatch watch_;
};

/// The landings of an arm that was found together with the field of its camera, and that is learned
/// further from the first look at every target. The field stays as it was found.
class LearningLandings final : public LandingModel {
 public:
  /// Takes a field and an arm that was found with it, what is known of the arm by now, and how far
  /// an arm that strayed may be off, per axis. Throws std::invalid_argument when they do not belong
  /// together.
  LearningLandings(LampField field, const FoundArm& found, LearnedArm known,
                   const Transmission& transmission, double stray_m);

  LandingPrior at(const Joints& theta_c, const TipMeasurement& look) const override;
  void learn(const SeenLanding& seen) override;
  std::optional<Doubt> doubt() const override { return watch_.doubt(); }
  const FoundArm* learned_arm() const override { return &learner_.learned().arm; }

  const ArmLearner& learner() const { return learner_; }

 private:
  /// Takes back what was learned where the arm as it was found explains a look that it does not.
  void unlearn(const SeenLanding& seen);

  LampField field_;
  FoundArm found_;
  LookWatch watch_;  ///< of the arm as it was found
  ArmLearner learner_;
  Transmission transmission_;
  double stray_m_;
  bool has_warned_{false};  ///< of looks beyond the caps
};

}  // namespace planar
