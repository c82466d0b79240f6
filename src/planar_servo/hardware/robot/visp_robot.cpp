#include "planar_servo/hardware/robot/visp_robot.h"

#include <visp3/robot/vpRobotException.h>

#include <Eigen/LU>
#include <cmath>

namespace planar {
namespace {

/// The sine of 3 degrees between the links. Nearer to a straight or folded arm, the joints would
/// turn more than 20 times as fast as at a right angle.
constexpr double kMinManipulability = 0.05;
/// The remainder of a zero velocity after a change of frames, at most, in m/s or rad/s.
constexpr double kZeroTwist = 1e-9;

[[noreturn]] void refuse_frame() {
  throw vpRobotException(vpRobotException::notImplementedError,
                         "VispRobot knows JOINT_STATE and REFERENCE_FRAME only");
}

void require_size(const vpColVector& values, unsigned int size) {
  if (values.size() == size) return;
  throw vpRobotException(vpRobotException::positionOutOfRangeError,
                         "VispRobot: a position or velocity of this frame has %u elements", size);
}

void require_state(vpRobot::vpRobotStateType state, vpRobot::vpRobotStateType needed,
                   const char* name) {
  if (state == needed) return;
  throw vpRobotException(vpRobotException::wrongStateError,
                         "VispRobot: call setRobotState(%s) first", name);
}

void require_finite(const vpColVector& velocity) {
  for (unsigned int i = 0; i < velocity.size(); ++i)
    if (!std::isfinite(velocity[i]))
      throw vpRobotException(vpRobotException::lowLevelError,
                             "VispRobot: element %u of the velocity is not finite", i);
}

/// Fills J: rows x and y of the twist from `tip_jacobian`, the rotation about z from joint 3.
void set_jacobian(const PlanarArm& arm, const Eigen::Matrix2d& tip_jacobian, vpMatrix& J) {
  J.resize(6, 3);
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column) J[row][column] = tip_jacobian(row, column);
  J[5][2] = arm.sense();
}

}  // namespace

void VispRobot::get_fJe(vpMatrix& J) {
  set_jacobian(robot_.arm(), robot_.arm().jacobian(robot_.present_joints()), J);
}

void VispRobot::get_eJe(vpMatrix& J) {
  const PlanarArm& arm = robot_.arm();
  const Joints theta = robot_.present_joints();
  set_jacobian(arm, rotation2d(arm.forward(theta).phi).transpose() * arm.jacobian(theta), J);
}

void VispRobot::getPosition(const vpControlFrameType frame, vpColVector& position) {
  const Joints theta = robot_.present_joints();
  if (frame == JOINT_STATE) {
    position.resize(3);
    for (int i = 0; i < 3; ++i) position[i] = theta[i];
  } else if (frame == REFERENCE_FRAME) {
    const TipPose tip = robot_.arm().forward(theta);
    position.resize(6);
    position[0] = tip.p.x();
    position[1] = tip.p.y();
    position[5] = wrap_angle(tip.phi);
  } else {
    refuse_frame();
  }
}

void VispRobot::setPosition(const vpControlFrameType frame, const vpColVector& position) {
  require_state(getRobotState(), STATE_POSITION_CONTROL, "STATE_POSITION_CONTROL");
  if (frame == JOINT_STATE) {
    require_size(position, 3);
    robot_.move_to({position[0], position[1], position[2]});
  } else if (frame == REFERENCE_FRAME) {
    robot_.move_to(joints_from_pose(position));
  } else {
    refuse_frame();
  }
}

Joints VispRobot::joints_from_pose(const vpColVector& pose) const {
  require_size(pose, 6);
  if (pose[2] != 0.0 || pose[3] != 0.0 || pose[4] != 0.0)
    throw vpRobotException(vpRobotException::positionOutOfRangeError,
                           "VispRobot: the tool stays in the plane z = 0, upright");
  const Joints near = robot_.commanded_joints();
  const InverseResult inverse =
      robot_.arm().inverse({{pose[0], pose[1]}, pose[5]}, robot_.arm().elbow(near), near);
  if (inverse.status != ReachStatus::kOk)
    throw vpRobotException(vpRobotException::positionOutOfRangeError, "VispRobot: %s",
                           describe(inverse.status));
  return inverse.theta;
}

void VispRobot::getDisplacement(const vpControlFrameType /*frame*/, vpColVector& /*q*/) {
  throw vpRobotException(vpRobotException::notImplementedError,
                         "VispRobot does not record displacements");
}

void VispRobot::setVelocity(const vpControlFrameType frame, const vpColVector& velocity) {
  require_state(getRobotState(), STATE_VELOCITY_CONTROL, "STATE_VELOCITY_CONTROL");
  require_finite(velocity);
  robot_.turn([&](const Joints& theta) -> Joints {
    if (frame == REFERENCE_FRAME) return joint_velocity(theta, velocity);
    if (frame != JOINT_STATE) refuse_frame();
    require_size(velocity, 3);
    const vpColVector v = saturateVelocities(velocity, vpColVector(3, getMaxRotationVelocity()));
    return {v[0], v[1], v[2]};
  });
}

Joints VispRobot::joint_velocity(const Joints& theta, const vpColVector& twist) const {
  require_size(twist, 6);
  for (const unsigned int i : {2U, 3U, 4U})
    if (std::abs(twist[i]) > kZeroTwist)
      throw vpRobotException(vpRobotException::notImplementedError,
                             "VispRobot: the tool stays in its plane, upright; vz, wx and wy "
                             "have to be 0");
  if (PlanarArm::manipulability(theta) < kMinManipulability)
    throw vpRobotException(vpRobotException::lowLevelError,
                           "VispRobot: the arm is nearly straight or folded: its tool cannot "
                           "move in every direction; use velocities of its joints");
  vpColVector most(6, getMaxTranslationVelocity());
  most[3] = most[4] = most[5] = getMaxRotationVelocity();
  const vpColVector v = saturateVelocities(twist, most);
  const Eigen::Matrix2d J = robot_.arm().jacobian(theta);
  const Eigen::Vector2d theta_dot = J.inverse() * Eigen::Vector2d(v[0], v[1]);
  return {theta_dot[0], theta_dot[1], robot_.arm().sense() * v[5]};
}

vpRobot::vpRobotStateType VispRobot::setRobotState(const vpRobotStateType state) {
  if (getRobotState() == STATE_VELOCITY_CONTROL && state != STATE_VELOCITY_CONTROL) {
    robot_.end_turning();
  } else if (state == STATE_STOP) {
    robot_.halt();
  }
  return vpRobot::setRobotState(state);
}

}  // namespace planar
