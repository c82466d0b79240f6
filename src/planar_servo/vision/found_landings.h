#pragma once

#include <optional>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/field/lamp_field.h"
#include "planar_servo/servo/landing_model.h"
#include "planar_servo/vision/look_watch.h"

namespace planar {

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

}  // namespace planar
