// This file holds the functions of vpRobot by which PlanarRobot serves the programs of ViSP.
#include <visp3/robot/vpRobotException.h>

#include <Eigen/LU>
#include <cmath>

#include "planar_servo/robot/planar_robot.h"

namespace planar {
namespace {

/// The sine of 3 degrees between the links. Nearer to a straight or folded arm, the joints would
/// turn more than 20 times as fast as at a right angle.
constexpr double kMinManipulability = 0.05;
/// What a change of frames may leave of a velocity of zero, in m/s or rad/s.
constexpr double kZeroTwist = 1e-9;

[[noreturn]] void refuse_frame() {
  throw vpRobotException(vpRobotException::notImplementedError,
                         "PlanarRobot knows JOINT_STATE and REFERENCE_FRAME only");
}

void require_size(const vpColVector& values, unsigned int size) {
  if (values.size() == size) return;
  throw vpRobotException(vpRobotException::positionOutOfRangeError,
                         "PlanarRobot: a position or velocity of this frame has %u elements", size);
}

void require_state(vpRobot::vpRobotStateType state, vpRobot::vpRobotStateType needed,
                   const char* name) {
  if (state == needed) return;
  throw vpRobotException(vpRobotException::wrongStateError,
                         "PlanarRobot: call setRobotState(%s) first", name);
}

void require_finite(const vpColVector& velocity) {
  for (unsigned int i = 0; i < velocity.size(); ++i)
    if (!std::isfinite(velocity[i]))
      throw vpRobotException(vpRobotException::lowLevelError,
                             "PlanarRobot: element %u of the velocity is not finite", i);
}

}  // namespace

Joints PlanarRobot::present_joints() {
  read_positions(drives_.status());
  return commanded_joints();
}

void PlanarRobot::get_fJe(vpMatrix& J) {
  set_jacobian(arm_.jacobian(present_joints()), J);
}

void PlanarRobot::get_eJe(vpMatrix& J) {
  const Joints theta = present_joints();
  set_jacobian(rotation2d(arm_.forward(theta).phi).transpose() * arm_.jacobian(theta), J);
}

void PlanarRobot::set_jacobian(const Eigen::Matrix2d& tip_jacobian, vpMatrix& J) const {
  J.resize(6, 3);
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) J[row][column] = tip_jacobian(row, column);
  }
  J[5][2] = arm_.sense();
}

void PlanarRobot::getPosition(const vpControlFrameType frame, vpColVector& position) {
  const Joints theta = present_joints();
  if (frame == JOINT_STATE) {
    position.resize(3);
    for (int i = 0; i < 3; ++i) position[i] = theta[i];
  } else if (frame == REFERENCE_FRAME) {
    const TipPose tip = arm_.forward(theta);
    position.resize(6);
    position[0] = tip.p.x();
    position[1] = tip.p.y();
    position[5] = wrap_angle(tip.phi);
  } else {
    refuse_frame();
  }
}

void PlanarRobot::setPosition(const vpControlFrameType frame, const vpColVector& position) {
  require_state(getRobotState(), STATE_POSITION_CONTROL, "STATE_POSITION_CONTROL");
  if (frame == JOINT_STATE) {
    require_size(position, 3);
    move_to({position[0], position[1], position[2]});
  } else if (frame == REFERENCE_FRAME) {
    move_to(joints_from_pose(position));
  } else {
    refuse_frame();
  }
}

Joints PlanarRobot::joints_from_pose(const vpColVector& pose) const {
  require_size(pose, 6);
  if (pose[2] != 0.0 || pose[3] != 0.0 || pose[4] != 0.0)
    throw vpRobotException(vpRobotException::positionOutOfRangeError,
                           "PlanarRobot: the tool stays in the plane z = 0, upright");
  const Joints near = commanded_joints();
  const InverseResult inverse = arm_.inverse({{pose[0], pose[1]}, pose[5]}, arm_.elbow(near), near);
  if (inverse.status != ReachStatus::kOk)
    throw vpRobotException(vpRobotException::positionOutOfRangeError, "PlanarRobot: %s",
                           describe(inverse.status));
  return inverse.theta;
}

void PlanarRobot::getDisplacement(const vpControlFrameType /*frame*/, vpColVector& /*q*/) {
  throw vpRobotException(vpRobotException::notImplementedError,
                         "PlanarRobot does not record displacements");
}

void PlanarRobot::setVelocity(const vpControlFrameType frame, const vpColVector& velocity) {
  require_state(getRobotState(), STATE_VELOCITY_CONTROL, "STATE_VELOCITY_CONTROL");
  require_finite(velocity);
  if (stopped()) end_turning();
  throw_if_stopped();
  const Status status = look_while_turning();
  if (frame == JOINT_STATE) {
    require_size(velocity, 3);
    const vpColVector v = saturateVelocities(velocity, vpColVector(3, getMaxRotationVelocity()));
    turn(status, {v[0], v[1], v[2]});
  } else if (frame == REFERENCE_FRAME) {
    turn(status, joint_velocity(velocity));
  } else {
    refuse_frame();
  }
}

PlanarRobot::Status PlanarRobot::look_while_turning() {
  try {
    Status status = require_ready();
    read_positions(status);
    return status;
  } catch (const std::exception& error) {
    halt_after(error);
    throw;
  }
}

void PlanarRobot::turn(const Status& status, const Joints& theta_dot) {
  const Eigen::Vector3d velocity =
      transmission_.pulses_per_rad().cwiseProduct(transmission_.motors_from_joints(theta_dot));
  const VelocityMove move =
      velocity_move(turning_, clock_.now_s(), status, velocity, rated_limits(), kVelocityHold_s);
  const Pulses target(move.targets_pulses[0], move.targets_pulses[1], move.targets_pulses[2]);
  if (const auto violation =
          transmission_.limit_violation(transmission_.joints_from_pulses(target)))
    throw WorkError("the arm refuses this velocity: " + *violation);
  try {
    drives_.set_limits(move.limits);
    drives_.set_targets(move.targets_pulses);
  } catch (const std::exception& error) {
    halt_after(error);
    throw;
  }
  turning_ = move;
}

void PlanarRobot::end_turning() {
  turn(look_while_turning(), Joints::Zero());
  try {
    wait_for_rest(kVelocityHold_s);
    drives_.set_limits(rated_limits());
  } catch (const std::exception& error) {
    halt_after(error);
    throw;
  }
}

Joints PlanarRobot::joint_velocity(const vpColVector& twist) const {
  const Joints theta = commanded_joints();
  require_size(twist, 6);
  for (const unsigned int i : {2U, 3U, 4U}) {
    if (std::abs(twist[i]) > kZeroTwist)
      throw vpRobotException(vpRobotException::notImplementedError,
                             "PlanarRobot: the tool stays in its plane, upright; vz, wx and wy "
                             "have to be 0");
  }
  if (PlanarArm::manipulability(theta) < kMinManipulability)
    throw vpRobotException(vpRobotException::lowLevelError,
                           "PlanarRobot: the arm is nearly straight or folded: its tool cannot "
                           "move in every direction; use velocities of its joints");
  vpColVector most(6, getMaxTranslationVelocity());
  most[3] = most[4] = most[5] = getMaxRotationVelocity();
  const vpColVector v = saturateVelocities(twist, most);
  const Eigen::Matrix2d J = arm_.jacobian(theta);
  const Eigen::Vector2d theta_dot = J.inverse() * Eigen::Vector2d(v[0], v[1]);
  return {theta_dot[0], theta_dot[1], arm_.sense() * v[5]};
}

vpRobot::vpRobotStateType PlanarRobot::setRobotState(const vpRobotStateType state) {
  if (getRobotState() == STATE_VELOCITY_CONTROL && state != STATE_VELOCITY_CONTROL) {
    end_turning();
  } else if (state == STATE_STOP) {
    halt();
  }
  return vpRobot::setRobotState(state);
}

}  // namespace planar
