#pragma once

#include <Eigen/Core>
#include <array>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"

namespace planar {

/// The places of lamps 1 and 2 on the plane of their motion, base frame, metres.
using LampPlaces = std::array<Eigen::Vector2d, 2>;

/// The numbers by which a cell may differ from its files, in the order of a vector of them. Angles
/// are in radians and lengths in metres.
enum Number : int {
  kZeroOff = 0,     ///< of motors 1 to 3, behind their gears
  kGearOff = 3,     ///< of motors 1 to 3: the share by which they turn too far, counted from home
  kLinkOff = 6,     ///< of the two lengths
  kLampOff = 8,     ///< x, y of lamp 1 and x, y of lamp 2 in the tool's frame
  kShiftOff = 12,   ///< x, y of the picture on the plane
  kTurnOff = 14,    ///< of the picture about the camera's optical axis
  kGrowthOff = 15,  ///< the share by which the picture is too large
  kTiltOff = 16,    ///< growth of the picture per metre along x and along y
  kNumbers = 18
};
using Numbers = Eigen::Matrix<double, kNumbers, 1>;

/// Models what a camera sees of a cell's lamps when its motors are commanded.
struct CellModel {
  double sense{1.0};
  Eigen::Vector2d links_m{0.3, 0.3};
  Eigen::Matrix3d coupling{Eigen::Matrix3d::Identity()};  ///< C of transmission.h
  Eigen::Vector3d home{0.0, 0.0, 0.0};   ///< the motors' angles at their marks or switches
  Eigen::Vector3d zeros{0.0, 0.0, 0.0};  ///< added to the motors' angles
  Eigen::Vector3d gears{1.0, 1.0, 1.0};  ///< true angle per commanded angle from home
  LampPlaces lamps_T;                    ///< the lamps in the tool's frame
  Eigen::Vector2d axis_B{0.0, 0.0};      ///< where the camera's optical axis meets the plane
  bool mirrored{false};                  ///< the picture, left to right
};

/// Returns where the lamps are seen with the motors commanded to these angles (radians, behind
/// their gears), in a cell that is `off` from the model. What a camera that has moved sees is given
/// to first order.
LampPlaces lamps_seen(const CellModel& model, const Eigen::Vector3d& motors,
                      const Numbers& off = Numbers::Zero());

}  // namespace planar
