#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/cell/servo_settings.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/tip_sensor.h"

namespace planar {

enum class ServoStatus {
  kReached,
  kOutsideMap,    ///< arrived by its own view, but where the error map is not valid
  kNotConverged,  ///< the iterations were used up
  kDiverged,      ///< the error grew twice in a row; the drives were halted
  kLostLamp,      ///< no measurement; nothing moved after it
  kLostCamera,    ///< the camera failed; the arm stopped where it was
  kRefused,       ///< target or correction beyond reach, workspace, limits, or near a singularity
};

/// As files have it: "reached", "outside_map", "not_converged", "diverged", "lost_lamp",
/// "lost_camera", "refused".
const char* name(ServoStatus status);

/// One measurement at rest: number 0 after the first, open-loop move, then one per correction.
struct ServoStep {
  int iteration{0};
  TipPose target;
  TipMeasurement measurement;
  Eigen::Vector2d error{0.0, 0.0};  ///< target minus measured position; valid with the measurement
  double stop_below_m{0.0};         ///< the norm of `error` at which the servo is content
  Joints theta_c{0.0, 0.0, 0.0};    ///< commanded
  Pulses pulses_c{0, 0, 0};         ///< commanded
};

struct ServoResult {
  ServoStatus status{ServoStatus::kRefused};
  std::string reason;  ///< in words, unless the target was reached
  TipPose target;
  int iterations{0};  ///< corrections made
  std::vector<ServoStep> steps;
  double duration_s{0.0};
};

/// Positions the end point by vision: an open-loop move by the inverse kinematics, then measured
/// corrections until
///   |p_d - p| < max(tolerance, 2 sigma_vision / sqrt(frames), one pulse).
/// Joint 3 is commanded from the target's phi and not corrected.
class PositionServo {
 public:
  using Observer = std::function<void(const ServoStep&)>;

  /// Robot, sensor and clock must outlive the servo. Throws std::invalid_argument for settings out
  /// of range.
  PositionServo(const ServoSettings& settings, const JointPlanner& planner, PlanarRobot& robot,
                TipSensor& sensor, Clock& clock);

  /// `observer` sees every step as soon as it is measured, while the arm rests. Throws
  /// std::invalid_argument for a target that is not finite and WorkError when a drive fails;
  /// everything else is in the result.
  ServoResult move_to(const TipPose& target, const Observer& observer = {});

 private:
  ServoStep measure(const TipPose& target, int iteration);
  /// Empty while the loop should go on.
  std::optional<ServoStatus> verdict(const std::vector<ServoStep>& steps) const;
  std::string reason_for(ServoStatus status, const ServoStep& last) const;
  JointPlan corrected_joints(const ServoStep& step) const;
  struct Obstacle {
    ServoStatus status;
    std::string reason;
  };
  /// Moves and settles; what forbids or stops the motion comes back.
  std::optional<Obstacle> command(const Joints& theta);
  double pulse_size_m() const;

  ServoSettings settings_;
  JointPlanner planner_;
  PlanarRobot& robot_;
  TipSensor& sensor_;
  Clock& clock_;
};

}  // namespace planar
