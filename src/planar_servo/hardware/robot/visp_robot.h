#pragma once

#include <visp3/robot/vpRobot.h>

#include "planar_servo/hardware/robot/planar_robot.h"

namespace planar {

/// The arm as a vpRobot, so that ViSP's programs can drive it by positions and by velocities. Its
/// frames are JOINT_STATE (theta, 3 elements) and REFERENCE_FRAME (the base: x, y, z, then
/// rotations, 6 elements). Other frames throw vpRobotException.
class VispRobot final : public vpRobot {
 public:
  /// Moves nothing. The robot must outlive it.
  explicit VispRobot(PlanarRobot& robot) : robot_(robot) { nDof = 3; }

  /// There is nothing to do: see PlanarRobot::energize().
  void init() override {}
  /// Returns the Jacobian of the tool's twist, 6 x 3, in the tool's frame.
  void get_eJe(vpMatrix& J) override;
  /// Returns the Jacobian of the tool's twist, 6 x 3, in the base frame.
  void get_fJe(vpMatrix& J) override;
  using vpRobot::getPosition;
  /// Reads where the drives stand now, also while they turn. A pose ends with its rotation vector.
  void getPosition(const vpControlFrameType frame, vpColVector& position) override;
  /// Only in STATE_POSITION_CONTROL. A pose of the base frame is reached with the present elbow.
  void setPosition(const vpControlFrameType frame, const vpColVector& position) override;
  /// Always throws: displacements are not recorded.
  void getDisplacement(const vpControlFrameType frame, vpColVector& displacement) override;
  /// Only in STATE_VELOCITY_CONTROL; returns at once. Turns the joints (rad/s), or moves the tool
  /// by a twist of the base frame (vx, vy in m/s and wz in rad/s; the others must be 0), as
  /// PlanarRobot::turn() does. A twist holds exactly only where the arm stands now. A velocity
  /// beyond getMaxTranslationVelocity() or getMaxRotationVelocity() is scaled as a whole. Throws
  /// vpRobotException for a velocity that is not finite or that no planar arm can have, and for a
  /// twist within 3 degrees of a straight arm, and what turn() throws.
  void setVelocity(const vpControlFrameType frame, const vpColVector& velocity) override;
  /// Leaving STATE_VELOCITY_CONTROL slows the arm down and returns when it rests, so that no
  /// position is lost; STATE_STOP halts otherwise.
  vpRobotStateType setRobotState(const vpRobotStateType state) override;

 private:
  Joints joint_velocity(const Joints& theta, const vpColVector& twist) const;
  Joints joints_from_pose(const vpColVector& pose) const;

  PlanarRobot& robot_;
};

}  // namespace planar
