#pragma once

#include <Eigen/Core>
#include <array>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"

namespace planar {

/// The places of lamps 1 and 2 on the plane of their motion, base frame, metres.
using LampPlaces = std::array<Eigen::Vector2d, 2>;

/// Models what a camera sees of a cell's lamps when its motors are commanded, with everything in it
/// that may differ from the cell's files. What a camera that has moved sees is given to first
/// order, about the point of the plane under it.
struct CellModel {
  double sense{1.0};
  Eigen::Vector2d links_m{0.3, 0.3};
  Eigen::Matrix3d coupling{Eigen::Matrix3d::Identity()};  ///< C of transmission.h
  Eigen::Vector3d zeros_rad{0.0, 0.0, 0.0};               ///< of the motors, behind their gears
  Eigen::Vector3d gears{1.0, 1.0, 1.0};  ///< true angle per commanded angle of each motor
  LampPlaces lamps_T;                    ///< the lamps in the tool's frame
  Eigen::Vector2d foot_B{0.0, 0.0};      ///< the point of the plane under the camera
  bool mirrored{false};
  Eigen::Vector2d shift_m{0.0, 0.0};  ///< of the picture on the plane
  double turn{0.0};
  double growth{0.0};
};

/// Returns the model of a cell that is as its files say. `foot_B` is where the camera looks from,
/// `lamps_T` where the lamps are on the tool.
CellModel model_of(const PlanarArm& arm, const Transmission& transmission,
                   const LampPlaces& lamps_T, const Eigen::Vector2d& foot_B);

/// Returns where the lamps are seen with the motors commanded to these angles (radians, behind
/// their gears).
LampPlaces lamps_seen(const CellModel& model, const Eigen::Vector3d& motors);

}  // namespace planar
