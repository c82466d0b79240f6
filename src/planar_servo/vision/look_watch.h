#pragma once

#include <optional>

#include "planar_servo/arm/following_error.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/field/lamp_field.h"
#include "planar_servo/servo/landing_model.h"
#include "planar_servo/vision/lamp_agreement.h"

namespace planar {

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

}  // namespace planar
