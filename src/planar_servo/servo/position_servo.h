#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/core/names.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/arrival.h"
#include "planar_servo/servo/motion_guard.h"
#include "planar_servo/servo/tip_sensor.h"

namespace planar {

/// Says how the way to a target ended.
enum class ServoStatus {
  kReached,       ///< the servo is content, within the map's valid region
  kOutsideMap,    ///< the servo is content, but the error map is not valid here
  kNotConverged,  ///< the iterations were used up
  kDiverged,      ///< the error grew twice in a row; the drives were halted
  kHeld,          ///< a look contradicts the command or the calibration; nothing moved after it
  kLostLamp,      ///< the tool was not measured; nothing moved after that
  kLostCamera,    ///< the camera failed; the arm stopped where it was
  kRefused,       ///< target or correction beyond reach, workspace, limits, or near a singularity
};

/// All statuses with the words that files have for them.
constexpr Named<ServoStatus> kServoStatuses[] = {{ServoStatus::kReached, "reached"},
                                                 {ServoStatus::kOutsideMap, "outside_map"},
                                                 {ServoStatus::kNotConverged, "not_converged"},
                                                 {ServoStatus::kDiverged, "diverged"},
                                                 {ServoStatus::kHeld, "held"},
                                                 {ServoStatus::kLostLamp, "lost_lamp"},
                                                 {ServoStatus::kLostCamera, "lost_camera"},
                                                 {ServoStatus::kRefused, "refused"}};

/// Returns the status's word.
const char* name(ServoStatus status);

/// Records one measurement at rest. Number 0 follows the first, open-loop move; each correction is
/// followed by one more.
struct ServoStep {
  int iteration{0};
  TipPose target;
  TipMeasurement measurement;
  Eigen::Vector2d error{0.0, 0.0};  ///< target minus measured position; valid with the measurement
  double turn_error{0.0};           ///< the same for the tool's direction, radians
  double stop_below_m{0.0};         ///< the servo is content when |error| is below this
  Joints theta_c{0.0, 0.0, 0.0};    ///< commanded joints
  Pulses pulses_c{0, 0, 0};         ///< commanded pulses
};

/// Records the way to one target and how it ended.
struct ServoResult {
  ServoStatus status{ServoStatus::kRefused};
  std::string reason;  ///< the reason in words; empty when the target was reached
  /// The cell itself is in doubt: another target would fare no better, or worse.
  bool cell_in_doubt{false};
  TipPose target;
  int iterations{0};  ///< number of corrections made
  std::vector<ServoStep> steps;
  double duration_s{0.0};
};

/// Positions the end point by vision: an open-loop move by the inverse kinematics, then measured
/// corrections until
///   |p_d - p| < max(tolerance, 2 sigma_vision / sqrt(frames), one pulse)
/// and the tool's direction is right within the orientation tolerance; joint 3 corrects that. A
/// look that motion_guard.h doubts moves nothing.
class PositionServo {
 public:
  /// Is called with every step as soon as it is measured, while the arm rests.
  using Observer = std::function<void(const ServoStep&)>;

  /// Takes robot, sensor and clock, which must outlive the servo. Throws std::invalid_argument for
  /// settings out of range.
  PositionServo(const ServoSettings& settings, const GuardLimits& limits,
                const JointPlanner& planner, PlanarRobot& robot, TipSensor& sensor, Clock& clock);

  /// Moves to a target and reports every step to `observer`. Throws std::invalid_argument for a
  /// target that is not finite and WorkError when a drive fails. Every other outcome is in the
  /// result.
  ServoResult move_to(const TipPose& target, const Observer& observer = {});

 private:
  ServoStep measure(const TipPose& target, int iteration);
  /// Returns how the motion ended, or nothing while the loop should go on.
  std::optional<ServoStatus> verdict(const std::vector<ServoStep>& steps) const;
  bool content(const ServoStep& step) const;
  std::string reason_for(ServoStatus status, const ServoStep& last) const;
  /// Says what is doubtful about a step's look, and keeps the look for the next one.
  std::optional<Doubt> doubt_of(const ServoStep& step);
  JointPlan corrected_joints(const ServoStep& step) const;
  /// Moves and settles. Returns what forbids or stops the motion, if anything does.
  std::optional<Obstacle> command(const Joints& theta);
  double pulse_size_m() const;

  ServoSettings settings_;
  GuardLimits limits_;
  JointPlanner planner_;
  PlanarRobot& robot_;
  TipSensor& sensor_;
  Clock& clock_;
  double arrived_s_{0.0};                 ///< when the last motion came to rest
  std::optional<GuardedLook> last_look_;  ///< the last one that was not doubted
};

}  // namespace planar
