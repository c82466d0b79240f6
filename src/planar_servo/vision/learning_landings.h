#pragma once

#include <optional>

#include "planar_servo/arm/arm_learner.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/field/lamp_field.h"
#include "planar_servo/servo/landing_model.h"
#include "planar_servo/vision/look_watch.h"

namespace planar {

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
