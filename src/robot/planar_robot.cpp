#include "robot/planar_robot.h"

#include <fmt/format.h>
#include <visp3/robot/vpRobotException.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace planar {
namespace {

constexpr double kPollPeriod_s = 5e-3;
/// A move may take this many times its computed duration, and this much more for the link.
constexpr double kTimeoutFactor = 2.0;
constexpr double kTimeoutMargin_s = 1.0;

std::string in_words(const std::vector<std::string>& faults) {
  return fmt::format("{}", fmt::join(faults, ", "));
}

/// Duration of a trapezoidal move from rest to rest, or of a triangular one if it is short.
double move_duration_s(double distance, double max_speed, double max_acceleration) {
  const double ramp = max_speed * max_speed / max_acceleration;
  if (distance < ramp) return 2.0 * std::sqrt(distance / max_acceleration);
  return distance / max_speed + max_speed / max_acceleration;
}

[[noreturn]] void refuse_frame() {
  throw vpRobotException(vpRobotException::notImplementedError,
                         "PlanarRobot knows JOINT_STATE and REFERENCE_FRAME only");
}

void require_size(const vpColVector& position, unsigned int size) {
  if (position.size() == size) return;
  throw vpRobotException(vpRobotException::positionOutOfRangeError,
                         "PlanarRobot: a position of this frame has %u elements", size);
}

}  // namespace

PlanarRobot::PlanarRobot(const PlanarArm& arm, const Transmission& transmission,
                         const std::array<PulseDrive*, 3>& drives, Clock& clock)
    : arm_(arm), transmission_(transmission), drives_(drives), clock_(clock) {
  nDof = 3;
  read_positions();
}

PlanarRobot::~PlanarRobot() {
  for (PulseDrive* drive : drives_) {
    try {
      if (drive->status().moving) drive->halt();
    } catch (const std::exception&) {
      // A drive out of touch stops by its own command time-out.
    }
  }
}

void PlanarRobot::energize() {
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& motor = transmission_.settings().drives[i];
    const double pulses_per_rad = std::abs(transmission_.pulses_per_rad()[i]);
    drives_[i]->set_limits(pulses_per_rad * motor.max_speed_rad_s,
                           pulses_per_rad * motor.max_acceleration_rad_s2);
    drives_[i]->energize();
  }
  require_ready();
  read_positions();
}

void PlanarRobot::move_to(const Joints& theta) {
  if (const auto violation = transmission_.limit_violation(theta)) {
    throw WorkError("the arm refuses to move: " + *violation);
  }
  const Pulses target = transmission_.pulses_from_joints(theta);
  require_ready();
  const double timeout_s = kTimeoutFactor * longest_move_s(target) + kTimeoutMargin_s;
  try {
    start_towards(target);
    wait_for_arrival(timeout_s);
  } catch (...) {
    halt();
    throw;
  }
}

void PlanarRobot::halt() {
  std::string failures;
  for (int i = 0; i < 3; ++i) {
    try {
      drives_[i]->halt();
      commanded_pulses_[i] = drives_[i]->status().position_pulses;
    } catch (const std::exception& error) {
      failures += fmt::format("{}drive {} does not halt: {}", failures.empty() ? "" : "; ", i + 1,
                              error.what());
    }
  }
  if (!failures.empty()) throw WorkError(failures);
}

void PlanarRobot::require_ready() {
  for (int i = 0; i < 3; ++i) {
    const DriveStatus status = drives_[i]->status();
    if (!status.faults.empty()) {
      throw WorkError(fmt::format("drive {} reports: {}", i + 1, in_words(status.faults)));
    }
    if (!status.energized) throw WorkError(fmt::format("drive {} is switched off", i + 1));
    if (!status.position_certain) {
      throw WorkError(fmt::format("drive {} has lost its position; home the arm", i + 1));
    }
  }
}

void PlanarRobot::start_towards(const Pulses& target) {
  for (int i = 0; i < 3; ++i) drives_[i]->set_target(target[i]);
  commanded_pulses_ = target;
}

void PlanarRobot::wait_for_arrival(double timeout_s) {
  const double deadline_s = clock_.now_s() + timeout_s;
  while (!all_have_arrived()) {
    if (clock_.now_s() > deadline_s) {
      throw WorkError(fmt::format("the drives have not arrived after {:.1f} s", timeout_s));
    }
    clock_.sleep_for_s(kPollPeriod_s);
  }
}

bool PlanarRobot::all_have_arrived() {
  bool arrived = true;
  for (int i = 0; i < 3; ++i) {
    const DriveStatus status = drives_[i]->status();
    if (!status.faults.empty() || !status.energized) {
      throw WorkError(fmt::format(
          "drive {} failed on its way: {}", i + 1,
          status.faults.empty() ? std::string("it is switched off") : in_words(status.faults)));
    }
    arrived = arrived && !status.moving && status.position_pulses == commanded_pulses_[i];
  }
  return arrived;
}

double PlanarRobot::longest_move_s(const Pulses& target) const {
  double longest_s = 0.0;
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& motor = transmission_.settings().drives[i];
    const double distance_rad = std::abs((target[i] - static_cast<double>(commanded_pulses_[i])) /
                                         transmission_.pulses_per_rad()[i]);
    longest_s = std::max(longest_s, move_duration_s(distance_rad, motor.max_speed_rad_s,
                                                    motor.max_acceleration_rad_s2));
  }
  return longest_s;
}

void PlanarRobot::read_positions() {
  for (int i = 0; i < 3; ++i) commanded_pulses_[i] = drives_[i]->status().position_pulses;
}

void PlanarRobot::get_fJe(vpMatrix& J) {
  set_jacobian(arm_.jacobian(commanded_joints()), J);
}

void PlanarRobot::get_eJe(vpMatrix& J) {
  const Joints theta = commanded_joints();
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
  const Joints theta = commanded_joints();
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
  if (getRobotState() != STATE_POSITION_CONTROL) {
    throw vpRobotException(vpRobotException::wrongStateError,
                           "PlanarRobot: call setRobotState(STATE_POSITION_CONTROL) first");
  }
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
  if (pose[2] != 0.0 || pose[3] != 0.0 || pose[4] != 0.0) {
    throw vpRobotException(vpRobotException::positionOutOfRangeError,
                           "PlanarRobot: the tool stays in the plane z = 0, upright");
  }
  const Joints near = commanded_joints();
  const InverseResult inverse = arm_.inverse({{pose[0], pose[1]}, pose[5]}, arm_.elbow(near), near);
  if (inverse.status != ReachStatus::kOk) {
    throw vpRobotException(vpRobotException::positionOutOfRangeError, "PlanarRobot: %s",
                           describe(inverse.status));
  }
  return inverse.theta;
}

void PlanarRobot::getDisplacement(const vpControlFrameType /*frame*/, vpColVector& /*q*/) {
  throw vpRobotException(vpRobotException::notImplementedError,
                         "PlanarRobot does not record displacements");
}

void PlanarRobot::setVelocity(const vpControlFrameType /*frame*/, const vpColVector& /*v*/) {
  throw vpRobotException(vpRobotException::notImplementedError,
                         "PlanarRobot moves in position control only");
}

vpRobot::vpRobotStateType PlanarRobot::setRobotState(const vpRobotStateType state) {
  if (state == STATE_STOP) halt();
  return vpRobot::setRobotState(state);
}

}  // namespace planar
