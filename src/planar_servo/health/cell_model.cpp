#include "planar_servo/health/cell_model.h"

#include <Eigen/LU>

#include "planar_servo/core/pose.h"

namespace planar {
namespace {

Eigen::Vector2d pictured(const CellModel& model, const Numbers& off, const Eigen::Vector2d& p_B) {
  Eigen::Vector2d from_axis = p_B - model.axis_B;
  if (model.mirrored) from_axis.x() = -from_axis.x();
  const double growth = 1.0 + off[kGrowthOff] + off.segment<2>(kTiltOff).dot(from_axis);
  return model.axis_B + off.segment<2>(kShiftOff) +
         growth * (rotation2d(off[kTurnOff]) * from_axis);
}

}  // namespace

LampPlaces lamps_seen(const CellModel& model, const Eigen::Vector3d& motors, const Numbers& off) {
  const Eigen::Vector3d gears =
      model.gears.cwiseProduct((off.segment<3>(kGearOff).array() + 1.0).matrix());
  const Eigen::Vector3d turned =
      model.home + gears.cwiseProduct(motors - model.home) + model.zeros + off.segment<3>(kZeroOff);
  const Eigen::Vector3d directions = model.sense * (model.coupling.inverse() * turned);
  const Eigen::Vector2d links_m = model.links_m + off.segment<2>(kLinkOff);
  const Eigen::Vector2d tip =
      links_m[0] * rotation2d(directions[0]).col(0) + links_m[1] * rotation2d(directions[1]).col(0);
  const Eigen::Matrix2d R = rotation2d(directions[2]);
  const Eigen::Vector2d lamp1_T = model.lamps_T[0] + off.segment<2>(kLampOff);
  const Eigen::Vector2d lamp2_T = model.lamps_T[1] + off.segment<2>(kLampOff + 2);
  return {pictured(model, off, tip + R * lamp1_T), pictured(model, off, tip + R * lamp2_T)};
}

}  // namespace planar
