#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/arm/transmission.h"

namespace planar {

/// Holds what three motors are told in order to turn at given velocities (pulses/s), although they
/// only know how to go to positions, and how fast they turned when they were told.
struct VelocityMove {
  double t_s{0.0};
  Eigen::Vector3d from{0.0, 0.0, 0.0};      ///< their velocities at t_s
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  ///< what they speed up or slow down to
  std::array<DriveLimits, 3> limits;
  std::array<std::int32_t, 3> targets_pulses{};
};

/// Returns the move that makes motors of this `status`, whose last move was `last`, turn at
/// `velocity` for `hold_s` and then slow down to rest, unless they are told anew before. Each
/// target lies ahead by that time and the way to brake. A velocity beyond the `rated` limits is
/// scaled as a whole. All motors change their velocity in the same time, and brake in the same
/// time, within their rated accelerations. A motor that is to rest goes no farther than it would.
VelocityMove velocity_move(const VelocityMove& last, double now_s,
                           const std::array<DriveStatus, 3>& status,
                           const Eigen::Vector3d& velocity, const std::array<DriveLimits, 3>& rated,
                           double hold_s);

/// The arm rests because somebody asked for it; no device failed.
class StopRequested : public WorkError {
 public:
  explicit StopRequested(const std::string& text) : WorkError(text, Cause::kStopped) {}
};

/// Moves the arm behind its three pulse drives: joint angles or their velocities in, absolute pulse
/// targets out. Joints count from 0. VispRobot drives it as a vpRobot.
///
/// Use it from one thread only. The destructor halts the drives if one still moves.
class PlanarRobot {
 public:
  /// Reads the drives' positions and moves nothing. Drives and clock must outlive the robot.
  PlanarRobot(const PlanarArm& arm, const Transmission& transmission, DriveGroup& drives,
              Clock& clock);
  ~PlanarRobot();
  PlanarRobot(const PlanarRobot&) = delete;
  PlanarRobot& operator=(const PlanarRobot&) = delete;

  /// Looks for lost drives, sets every drive's speed and acceleration, and switches all on. Throws
  /// DriveError naming the drive that reports a fault or does not switch on. A drive may still have
  /// to be homed. After a stop by hand that this program has seen only switch_on() does that;
  /// energize() and recover() throw StoppedByHand.
  void energize();
  void switch_on();

  /// Sets a predicate that is asked every few milliseconds during every move, homing and wait for a
  /// drive. While it returns true, nothing moves and these throw StopRequested: a move slows down
  /// to rest, so that no position is lost, and a homing halts. An empty one never stops the arm.
  void stop_when(std::function<bool()> stop) { stop_ = std::move(stop); }
  void throw_if_stopped() const;

  /// Returns the joints whose drives do not know their position.
  std::vector<int> unhomed();
  /// Asks the drives anew where they stand, for a robot whose drives another one has moved.
  void read_drives() { read_positions(drives_.status()); }
  /// Waits, as until an arm has ceased to swing.
  void wait_for_s(double duration_s) { clock_.sleep_for_s(duration_s); }

  /// Moves a motor to its home switch and counts its position from there. Throws DriveError when it
  /// has no switch, does not find it or fails; all motors halt then.
  void search_home(int joint);
  /// A search for the home switch is given up after this time. Only the drive knows its speed.
  static constexpr double kHomingTimeout_s{180.0};

  /// Returns the motor's angle behind its gear at its mark, radians; empty where it has no mark.
  std::optional<double> home_mark(int joint) const;

  /// Declares that a motor stands at its mark now.
  void teach_home(int joint);

  /// Returns whether the camera says where the joints stand.
  bool homes_by_sight() const;
  /// Declares that the joints stand there now. Throws std::out_of_range beyond 32 bits of pulses.
  void set_joints(const Joints& theta);
  /// Makes the drives unsure of their positions, and plans nothing until they are homed again.
  void forget_position();

  /// Looks for lost drives and switches all on again after a failure, with growing pauses until it
  /// works. Throws the last DriveError when `patience_s` is over. Nothing moves. Drives that lost
  /// their position are unhomed() then.
  void recover(double patience_s);

  /// Returns the pulses that were commanded last, and their joint angles; nothing while a drive
  /// does not know its position, from a reset or an abrupt stop until it is homed, taught or set.
  std::optional<Pulses> known_pulses() const;
  std::optional<Joints> known_joints() const;
  /// The same for what plans from there. Throws DriveError naming the drives to be homed.
  Pulses commanded_pulses() const;
  Joints commanded_joints() const { return transmission_.joints_from_pulses(commanded_pulses()); }

  /// Is asked every few milliseconds while the arm moves; returns why it must stop, if it must.
  using Guard = std::function<std::optional<std::string>()>;

  /// Moves every motor to round(K C theta) and returns when all have arrived.
  ///
  /// When `guard` objects, all motors slow down to rest, so that no position is lost, and its words
  /// are returned; nothing moves when it objects from the start.
  ///
  /// Nothing moves and it throws std::invalid_argument for angles that are not finite, WorkError
  /// when a motor's limits forbid the move, and DriveError when a drive is off, faulty or unsure of
  /// its position. When a drive fails or loses its position on the way, or does not arrive in time,
  /// all halt and DriveError names it.
  std::optional<std::string> move_to(const Joints& theta, const Guard& guard = {});

  /// Stops every drive at once. A drive that was moving may have lost its position. Throws
  /// DriveError naming the drives that could not be told.
  void halt();

  /// Reads where the drives stand, also while they turn. Throws DriveError when one does not know.
  Joints present_joints();

  /// A velocity holds for this time; unless the next one comes before, the arm slows down to rest.
  static constexpr double kVelocityHold_s{0.2};

  /// Returns the velocities of the joints, rad/s, for their present angles.
  using VelocityLaw = std::function<Joints(const Joints& theta)>;

  /// Turns the joints at these velocities for kVelocityHold_s and returns at once. Call it again
  /// before that, at best every 20 ms. Velocities beyond what the motors can do are scaled as a
  /// whole. Until end_turning() the arm is under velocity control and moves to no position.
  ///
  /// A refused velocity counts as silence: the arm slows down to rest. Throws what `velocity`
  /// throws, std::invalid_argument for velocities that are not finite, WorkError for drives with a
  /// stream_refusal() and where a motor would leave its limits if the velocity were kept,
  /// StopRequested, at rest, and DriveError, after all were halted, when a drive fails. A drive
  /// stops by its command timeout where that is shorter than kVelocityHold_s and the way to brake.
  void turn(const VelocityLaw& velocity);

  /// Slows down to rest, so that no position is lost, and gives the drives their own speeds again.
  void end_turning();

  const PlanarArm& arm() const { return arm_; }
  const Transmission& transmission() const { return transmission_; }

 private:
  using Status = std::array<DriveStatus, 3>;

  /// Returns the drives' states, and keeps the first stop by hand among them.
  Status status();
  /// Throws StoppedByHand where such a stop was seen since switch_on(), else DriveError.
  [[noreturn]] void throw_failure(const std::string& fault) const;
  /// Does something, and halts all drives where that throws. When one cannot be told, throws
  /// DriveError with the cause and that drive.
  template <typename Deed>
  auto or_halt(const Deed& deed);
  /// Returns the drives' states. Throws DriveError for one that is faulty or off, which `does`
  /// says.
  Status require_well(const char* does = "reports");
  /// As require_well(), requires also that every drive knows its position, and notes the speeds.
  Status require_ready();
  bool stopped() const { return stop_ && stop_(); }
  /// Polls the drives until `arrived`. Throws DriveError when a drive fails or it takes too long.
  void wait_for(double timeout_s, const std::function<bool(const Status&)>& arrived);
  Status status_under_way();
  void note_speeds(const Status& status);
  /// Moves to the target, or to rest on the way when `must_rest`.
  void travel(const Pulses& target, const std::function<bool()>& must_rest);
  /// Sends every moving motor to where it can stop, which lies between where it was seen last and
  /// its target, and waits until all rest. A motor that slows down already was faster, on average,
  /// since the look before: by its speed alone it would be sent beyond its target.
  void brake();
  void wait_for_rest(double duration_s);
  /// As require_ready(), and notes where the arm stands; halts all before it throws.
  Status look_while_turning();
  void turn(const Status& status, const Joints& theta_dot);
  const MotorDrive& motor_drive(int joint) const;
  std::int32_t home_pulses(int joint) const;
  void read_positions(const Status& status);

  PlanarArm arm_;
  Transmission transmission_;
  DriveGroup& drives_;
  Clock& clock_;
  std::function<bool()> stop_;
  std::array<std::optional<std::int32_t>, 3> commanded_pulses_;  ///< empty while unknown
  std::array<bool, 3> forgotten_{};  ///< the drive's own position counts for nothing
  VelocityMove turning_;             ///< the last one, under velocity control
  bool velocity_control_{false};
  std::string by_hand_;  ///< the first stop by hand that was seen since switch_on(), in words
  Eigen::Vector3d seen_pulses_{0.0, 0.0, 0.0};  ///< at the last look, when, and how fast
  double seen_s_{0.0};
  Eigen::Vector3d speed_pulses_s_{0.0, 0.0, 0.0};
};

}  // namespace planar
