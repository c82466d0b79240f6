#include "planar_servo/vision/look_watch.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "planar_servo/core/units.h"

namespace planar {

Eigen::Matrix2Xd vision_rows(const LampField& field, const TipMeasurement& look) {
  // Vision takes the found field off, and sees beside the truth by minus what its rows make of the
  // end point.
  return -end_point_rows(field, look.lamps_B) * field.factor;
}

ArmLook arm_look(const SeenLanding& seen, const LampField& field,
                 const Transmission& transmission) {
  return {transmission.motors_from_joints(seen.theta_c), seen.look.tip.p,
          vision_rows(field, seen.look), std::hypot(seen.scatter_m, seen.look.noise_m())};
}

LookWatch::LookWatch(LampField field, FoundArm found, const Transmission& transmission)
    : field_(std::move(field)),
      found_(std::move(found)),
      transmission_(transmission),
      following_(found_) {}

void LookWatch::take(const SeenLanding& seen) {
  of_view_.reset();
  const auto lamps_B = compensate(field_, seen.look.lamps_B).lamps_B;
  const double separation_m = (lamps_B[1] - lamps_B[0]).norm();
  const TipPose landed = found_.tip(transmission_.motors_from_joints(seen.theta_c));
  const double turn = wrap_angle(seen.look.tip.phi - landed.phi);
  if (seen.is_first && !seen.has_strayed) {
    following_.take(arm_look(seen, field_, transmission_), seen.look.t_s);
    lamps_.take(separation_m, turn);
  }
  if (!seen.stays_off) return;
  const bool agrees = lamps_.agrees(separation_m, turn);
  of_view_ = {
      fmt::format(
          "the tool is seen {:.3f} mm from where the arm should land here, as before the arm "
          "went away and came again, and {}: is something on the camera's window or in its "
          "view (a drop, a reflection), or does the arm stray? planar-check-cell says what "
          "has moved",
          (seen.look.tip.p - landed.p).norm() / kMillimetre,
          agrees           ? "the lamps stand to each other as at other targets"
          : lamps_.knows() ? "the lamps do not stand to each other as at other targets"
                           : "too few other targets were seen to compare the lamps with"),
      lamps_.knows() && !agrees};
}

std::optional<Doubt> LookWatch::doubt() const {
  if (of_view_) return of_view_;
  if (std::string moved = following_.doubt(); !moved.empty()) return Doubt{std::move(moved), true};
  return std::nullopt;
}

bool LookWatch::explains(const SeenLanding& seen) const {
  return following_.explains(arm_look(seen, field_, transmission_));
}

}  // namespace planar
