#include "planar_servo/health/cell_model.h"

#include <Eigen/LU>

#include "planar_servo/core/plane_geometry.h"

namespace planar {
namespace {

Eigen::Vector2d pictured(const CellModel& model, const Eigen::Vector2d& p_B) {
  Eigen::Vector2d from_foot = p_B - model.foot_B;
  if (model.mirrored) from_foot.x() = -from_foot.x();
  return model.foot_B + model.shift_m + (1.0 + model.growth) * (rotation2d(model.turn) * from_foot);
}

}  // namespace

CellModel model_of(const PlanarArm& arm, const Transmission& transmission,
                   const LampPlaces& lamps_T, const Eigen::Vector2d& foot_B) {
  CellModel model;
  model.sense = arm.sense();
  model.links_m = arm.geometry().link_lengths_m;
  model.coupling = transmission.coupling_matrix();
  model.lamps_T = lamps_T;
  model.foot_B = foot_B;
  return model;
}

LampPlaces lamps_seen(const CellModel& model, const Eigen::Vector3d& motors) {
  const Eigen::Vector3d turned = model.gears.cwiseProduct(motors) + model.zeros_rad;
  const Eigen::Vector3d directions = model.sense * (model.coupling.inverse() * turned);
  const Eigen::Vector2d tip = model.links_m[0] * rotation2d(directions[0]).col(0) +
                              model.links_m[1] * rotation2d(directions[1]).col(0);
  const Eigen::Matrix2d R = rotation2d(directions[2]);
  return {pictured(model, tip + R * model.lamps_T[0]), pictured(model, tip + R * model.lamps_T[1])};
}

}  // namespace planar
