#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/hardware/robot/homing.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/loop/vision/lamp_tip_sensor.h"

namespace planar {

/// A posture that the lamps in a picture allow.
struct PostureCandidate {
  Joints theta{0.0, 0.0, 0.0};  ///< with every motor on the turn within its limits nearest to home
  Elbow elbow{Elbow::kLeft};
  bool exchanged{false};  ///< the first of the lamps seen is lamp 2
};

/// Returns the postures of an arm whose lamps are at these places of the plane, in any order: both
/// elbows, and both orders of the lamps (theory section 20). Those are left out that no turns of
/// the motors bring within their limits.
std::vector<PostureCandidate> posture_candidates(const CalibratedCell& cell,
                                                 const std::array<Eigen::Vector2d, 2>& lamps_B);

/// Finds how the joints of a calibrated arm stand, in any pose in which both lamps are seen, and
/// sets the drives' positions. Small turns of motor 2 tell the elbows apart, a quarter turn of
/// joint 3 tells which lamp is which. Each is made only where the limits, the workspace and the
/// obstacles allow it for every posture and every turn of the motors that is still possible. Of
/// several turns of a motor within its limits `may_home` is asked for the one nearest to home.
/// Throws WorkError where the lamps are not seen, a turn that is needed is not allowed, or what is
/// seen fits no posture or several; the drives do not know their position then.
void home_by_sight(const CalibratedCell& cell, PlanarRobot& robot, LampTipSensor& sensor,
                   const MayHome& may_home);

}  // namespace planar
