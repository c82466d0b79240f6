#pragma once

#include <string>

#include "planar_servo/arm/following_error.h"
#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/field/lamp_field.h"
#include "planar_servo/servo/landing_model.h"

namespace planar {

/// Returns the rows by which vision, compensated by the field, is wrong at a look.
Eigen::Matrix2Xd vision_rows(const LampField& field, const TipMeasurement& look);

/// Returns a look that the guard let through as it speaks of the arm.
ArmLook arm_look(const SeenLanding& seen, const LampField& field, const Transmission& transmission);

/// The landings of an arm that was found together with the field of its camera. What is known of
/// both has one covariance.
class FoundLandings final : public LandingModel {
 public:
  /// Takes field and arm, which have the same columns in their factors, and how far an arm that
  /// strayed may be off, per axis.
  FoundLandings(LampField field, FoundArm arm, const Transmission& transmission, double stray_m);

  LandingPrior at(const Joints& theta_c, const TipMeasurement& look) const override;
  void learn(const SeenLanding& seen) override;
  std::string doubt() const override { return following_.doubt(); }

 private:
  LampField field_;
  FoundArm arm_;
  Transmission transmission_;
  double stray_m_;
  FollowingError following_;
};

}  // namespace planar
