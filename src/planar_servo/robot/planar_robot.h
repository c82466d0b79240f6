#pragma once

#include <visp3/robot/vpRobot.h>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/core/error.h"
#include "planar_servo/devices/drive_group.h"
#include "planar_servo/robot/velocity_move.h"

namespace planar {

/// The arm rests because somebody asked for it; no device failed.
class StopRequested : public WorkError {
 public:
  using WorkError::WorkError;
};

/// The arm behind its three pulse drives: joint angles in, absolute pulse targets out. Also a
/// vpRobot, so that ViSP's programs can drive it, by positions and by velocities. Joints count
/// from 0.
///
/// Not for use from several threads. Destruction halts the drives if one still moves.
class PlanarRobot final : public vpRobot {
 public:
  /// Reads where the drives stand; moves nothing. Drives and clock must outlive the robot.
  PlanarRobot(const PlanarArm& arm, const Transmission& transmission, DriveGroup& drives,
              Clock& clock);
  ~PlanarRobot() override;
  PlanarRobot(const PlanarRobot&) = delete;
  PlanarRobot& operator=(const PlanarRobot&) = delete;

  /// Gives every drive its speed and acceleration and switches it on, a lost one once it is found.
  /// Throws DriveError naming the drive that reports a fault or does not switch on. A drive may
  /// still have to be homed.
  void energize();

  /// `stop` is asked every few milliseconds of every motion, search and wait for a drive. When it
  /// says so, a move slows down to rest, so that no position is lost, a search halts, and they
  /// throw StopRequested; nothing moves any more while it says so. Empty: nobody stops the arm.
  void stop_when(std::function<bool()> stop) { stop_ = std::move(stop); }
  void throw_if_stopped() const;

  /// The joints whose drives do not know where they stand.
  std::vector<int> unhomed();

  /// Lets a motor look for its home switch, which moves the arm, and counts its position from
  /// there. Throws DriveError when it has none, does not find it or fails; all halt then.
  void search_home(int joint);

  /// Declares that a motor stands at its mark now.
  void teach_home(int joint);

  /// After a drive failed: gets back into touch with lost drives and switches all on again, with
  /// growing pauses until it works; throws the last DriveError when `patience_s` is over. Nothing
  /// moves. Drives that lost their position are unhomed() then.
  void recover(double patience_s);

  /// What the pulses sent last stand for: whole pulses, so the angles carry no remainder.
  Joints commanded_joints() const { return transmission_.joints_from_pulses(commanded_pulses_); }
  const Pulses& commanded_pulses() const { return commanded_pulses_; }

  /// Asked every few milliseconds while the arm moves; words say why it must stop.
  using Guard = std::function<std::optional<std::string>()>;

  /// Moves every motor to round(K C theta) and returns when all have arrived. Nothing moves unless
  /// all can: throws std::invalid_argument for angles that are not finite, WorkError when a motor's
  /// limits forbid the move, DriveError when a drive is off, faulty or unsure of its position. A
  /// drive that fails on the way or does not arrive in time: all halt, then DriveError names it.
  /// When `guard` objects, all slow down to rest, so that no position is lost, and its words come
  /// back; nothing moves when it objects from the start.
  std::optional<std::string> move_to(const Joints& theta, const Guard& guard = {});

  /// Stops every drive at once; throws DriveError naming those that could not be told. A drive that
  /// was moving may have lost its position.
  void halt();

  const PlanarArm& arm() const { return arm_; }
  const Transmission& transmission() const { return transmission_; }

  // vpRobot. Its frames: JOINT_STATE (theta, 3 elements) and REFERENCE_FRAME (the base: x, y, z,
  // then rotations, 6 elements). What else ViSP offers throws vpRobotException.

  /// A velocity holds for so long; unless the next one comes before, the arm slows down to rest.
  static constexpr double kVelocityHold_s{0.2};

  /// There is nothing to do: see energize().
  void init() override {}
  /// 6 x 3, in the frame of the tool.
  void get_eJe(vpMatrix& J) override;
  /// 6 x 3, in the base frame.
  void get_fJe(vpMatrix& J) override;
  using vpRobot::getPosition;
  /// Where the drives stand now, also while they turn. A pose ends with its rotation vector.
  void getPosition(const vpControlFrameType frame, vpColVector& position) override;
  /// Only in STATE_POSITION_CONTROL. A pose of the base frame is reached with the elbow as it is.
  void setPosition(const vpControlFrameType frame, const vpColVector& position) override;
  /// Always throws: displacements are not recorded.
  void getDisplacement(const vpControlFrameType frame, vpColVector& displacement) override;
  /// Only in STATE_VELOCITY_CONTROL; returns at once. Turns the joints (rad/s), or moves the tool
  /// by a twist of the base frame (vx, vy in m/s and wz in rad/s; the others must be 0), for
  /// kVelocityHold_s. Call it again before that, at best every 20 ms, since a twist holds exactly
  /// only where the arm stands now. A velocity beyond getMaxTranslationVelocity(),
  /// getMaxRotationVelocity() or what the motors can do is scaled as a whole.
  ///
  /// What is refused counts as silence: the arm slows down to rest. Throws vpRobotException for a
  /// velocity that is not finite or that no planar arm can have, and for a twist within 3 degrees
  /// of a straight arm; WorkError where a motor would leave its limits if the velocity were kept;
  /// StopRequested, at rest; DriveError, after all were halted, when a drive fails. A drive with a
  /// command timeout shorter than kVelocityHold_s and the way to brake stops by that timeout.
  void setVelocity(const vpControlFrameType frame, const vpColVector& velocity) override;
  /// Leaving STATE_VELOCITY_CONTROL slows the arm down and returns when it rests, so that no
  /// position is lost; STATE_STOP halts otherwise.
  vpRobotStateType setRobotState(const vpRobotStateType state) override;

 private:
  using Status = std::array<DriveStatus, 3>;

  /// Throws only when a drive cannot be told, with what led to it.
  void halt_after(const std::exception& cause);
  Status require_well();
  /// As require_well(), and every drive knows its position. Notes the speeds.
  Status require_ready();
  bool stopped() const { return stop_ && stop_(); }
  /// Polls until `arrived`; throws DriveError for a drive that fails or when it takes too long.
  void wait_for(double timeout_s, const std::function<bool(const Status&)>& arrived);
  Status status_under_way();
  void note_speeds(const Status& status);
  /// To the target, or to rest on the way there.
  void travel(const Pulses& target, const std::function<bool()>& must_rest);
  /// Sends every motor that moves to where it can stop, and waits until all rest.
  void brake();
  void wait_for_rest(double duration_s);
  /// As require_ready(), and notes where the arm stands; halts all before it throws.
  Status look_while_turning();
  /// Turns the joints, which have this status, at velocities (rad/s) for kVelocityHold_s.
  void turn(const Status& status, const Joints& theta_dot);
  /// Slows down to rest and gives the drives their own speeds again.
  void end_turning();
  const MotorDrive& motor_drive(int joint) const;
  std::array<DriveLimits, 3> rated_limits() const;
  std::int32_t home_pulses(int joint) const;
  double longest_move_s(const Pulses& target) const;
  /// The twist's rows x and y from `tip_jacobian`, its row of rotation about z from joint 3.
  void set_jacobian(const Eigen::Matrix2d& tip_jacobian, vpMatrix& J) const;
  Joints present_joints();
  Joints joints_from_pose(const vpColVector& pose) const;
  Joints joint_velocity(const vpColVector& twist) const;
  void read_positions(const Status& status);

  PlanarArm arm_;
  Transmission transmission_;
  DriveGroup& drives_;
  Clock& clock_;
  std::function<bool()> stop_;
  Pulses commanded_pulses_{0, 0, 0};
  VelocityMove turning_;                        ///< the last one, under velocity control
  Eigen::Vector3d seen_pulses_{0.0, 0.0, 0.0};  ///< at the last look, when, and how fast
  double seen_s_{0.0};
  Eigen::Vector3d speed_pulses_s_{0.0, 0.0, 0.0};
};

}  // namespace planar
