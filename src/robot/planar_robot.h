#pragma once

#include <visp3/robot/vpRobot.h>

#include <array>
#include <optional>
#include <string>

#include "arm/planar_arm.h"
#include "arm/transmission.h"
#include "core/clock.h"
#include "devices/pulse_drive.h"

namespace planar {

/// The arm behind its three pulse drives, in position control: joint angles in, absolute pulse
/// targets out. Also a vpRobot, so that ViSP's programs can drive it.
///
/// Not for use from several threads. Destruction halts every drive that still moves.
class PlanarRobot final : public vpRobot {
 public:
  /// Reads where the drives stand; moves nothing. Drives and clock must outlive the robot.
  PlanarRobot(const PlanarArm& arm, const Transmission& transmission,
              const std::array<PulseDrive*, 3>& drives, Clock& clock);
  ~PlanarRobot() override;
  PlanarRobot(const PlanarRobot&) = delete;
  PlanarRobot& operator=(const PlanarRobot&) = delete;

  /// Gives every drive its speed and acceleration and switches it on. Throws WorkError naming the
  /// drive that reports a fault or does not switch on.
  void energize();

  /// What the pulses sent last stand for: whole pulses, so the angles carry no remainder.
  Joints commanded_joints() const { return transmission_.joints_from_pulses(commanded_pulses_); }
  const Pulses& commanded_pulses() const { return commanded_pulses_; }

  /// Moves every motor to round(K C theta) and returns when all have arrived. Nothing moves unless
  /// all can: throws std::invalid_argument for angles that are not finite, WorkError when a motor's
  /// limits forbid the move or a drive is off, faulty or unsure of its position. A drive that fails
  /// on the way or does not arrive in time: all halt, then WorkError names it.
  void move_to(const Joints& theta);

  /// Stops every drive at once. A drive that was moving may have lost its position.
  void halt();

  const PlanarArm& arm() const { return arm_; }
  const Transmission& transmission() const { return transmission_; }

  // vpRobot. Its frames: JOINT_STATE (theta, 3 elements) and REFERENCE_FRAME (the base: x, y, z,
  // then the rotation vector, 6 elements). What else ViSP offers throws vpRobotException.
  void init() override {}
  /// 6 x 3, in the frame of the tool.
  void get_eJe(vpMatrix& J) override;
  /// 6 x 3, in the base frame.
  void get_fJe(vpMatrix& J) override;
  using vpRobot::getPosition;
  void getPosition(const vpControlFrameType frame, vpColVector& position) override;
  /// Only in STATE_POSITION_CONTROL. A pose of the base frame is reached with the elbow as it is.
  void setPosition(const vpControlFrameType frame, const vpColVector& position) override;
  void getDisplacement(const vpControlFrameType frame, vpColVector& displacement) override;
  void setVelocity(const vpControlFrameType frame, const vpColVector& velocity) override;
  /// STATE_STOP halts.
  vpRobotStateType setRobotState(const vpRobotStateType state) override;

 private:
  void require_ready();
  void start_towards(const Pulses& target);
  void wait_for_arrival(double timeout_s);
  bool all_have_arrived();
  double longest_move_s(const Pulses& target) const;
  /// The twist's rows x and y from `tip_jacobian`, its row of rotation about z from joint 3.
  void set_jacobian(const Eigen::Matrix2d& tip_jacobian, vpMatrix& J) const;
  Joints joints_from_pose(const vpColVector& pose) const;
  void read_positions();

  PlanarArm arm_;
  Transmission transmission_;
  std::array<PulseDrive*, 3> drives_;
  Clock& clock_;
  Pulses commanded_pulses_{0, 0, 0};
};

}  // namespace planar
