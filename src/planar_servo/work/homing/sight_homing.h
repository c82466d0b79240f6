#pragma once

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/hardware/robot/homing.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/loop/vision/lamp_tip_sensor.h"

namespace planar {

/// Finds how the joints of a calibrated arm stand, in any pose in which both lamps are seen, and
/// sets the drives' positions. Small turns of motor 2 tell the elbows apart, a turn of joint 3
/// tells which lamp is which: only test_turns(), which every posture and every turn of the motors
/// that is still possible allow. Of several turns of a motor within its limits `may_home` is asked
/// for the one nearest to home. Throws WorkError where the lamps are not seen, no turn that tells
/// is allowed, or what is seen fits no posture or several; the drives do not know their position
/// then.
void home_by_sight(const CalibratedCell& cell, PlanarRobot& robot, LampTipSensor& sensor,
                   const MayHome& may_home);

}  // namespace planar
