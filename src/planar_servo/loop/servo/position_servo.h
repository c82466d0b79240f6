#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/loop/servo/landing_estimator.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/loop/servo/servo_result.h"

namespace planar {

/// Says whether a law gave a step.
enum class LawStatus {
  kOk,
  kSingular,     ///< the links are within 3 degrees of being in line
  kUnreachable,  ///< the inverse law's measured or desired point is out of reach
};

/// Returns the status in words, for messages.
const char* describe(LawStatus status);

/// Holds a law's step of joints 1 and 2, radians.
struct LawStep {
  LawStatus status{LawStatus::kOk};
  Eigen::Vector2d delta_theta{0.0, 0.0};  ///< valid only when status is kOk
};

/// What a law starts from: commanded joints (radians), measured and desired end point (base frame).
struct LawInput {
  Joints theta{0.0, 0.0, 0.0};
  Eigen::Vector2d p{0.0, 0.0}, p_d{0.0, 0.0};
};

/// Computes the step J^+ (p_d - p) times a gain lambda, by ViSP's vpServo. lambda is `gain` at the
/// target and falls to half of it far away. This is vpAdaptiveGain of the step x in radians; its
/// slope at 0 is -gain, as the relative error of the linear model grows like x.
LawStep jacobian_law(const PlanarArm& arm, const LawInput& input, double gain);

/// Computes the step gain (theta(p_d) - theta(p)) by the inverse kinematics with the present elbow.
/// With a gain of 1 it is the paper's law.
LawStep inverse_law(const PlanarArm& arm, const LawInput& input, double gain);

/// Positions the end point by vision: an open-loop move by the inverse kinematics, then measured
/// corrections until the servo is content. A look that motion_guard.h doubts moves nothing; joint 3
/// corrects the tool's direction.
///
/// With a model of landings, all looks at a target tell where the end point is expected to be and
/// what to command next (LandingEstimator). The servo is content when
///   |p_d - E[l]| < max(tolerance, one pulse)
/// and the direction is right within the orientation tolerance. It gives up early when no
/// correction is expected to end nearer. Without a model every look is accepted as it is, its whole
/// error is corrected, and the servo is content when
///   |p_d - p| < max(tolerance, 2 noise, one pulse).
class PositionServo {
 public:
  /// Is called with every step as soon as it is measured, while the arm rests.
  using Observer = std::function<void(const ServoStep&)>;

  /// Takes robot, sensor, clock and, if there is one, the model, which must outlive the servo. The
  /// planner knows where the arm, as it was found, lands; a model that learns the arm updates it at
  /// each target. The guard compares looks with the planner's arm() alone. Throws
  /// std::invalid_argument for settings out of range.
  PositionServo(const ServoSettings& settings, const GuardLimits& limits,
                const JointPlanner& planner, PlanarRobot& robot, TipSensor& sensor, Clock& clock,
                LandingModel* landings = nullptr);
  /// Moves to a target and reports every step to `observer`. Throws std::invalid_argument for a
  /// target that is not finite and WorkError when a drive fails. Every other outcome is in the
  /// result.
  ///
  /// `target` is where P and the tool's direction are wanted. Where the tip `p_TE` of a tool is
  /// what matters, P follows the direction as it is seen: a direction that is right within its
  /// tolerance is not turned, and P is placed so that the tip is at its target all the same.
  ServoResult move_to(const TipPose& target, const Observer& observer = {},
                      const Eigen::Vector2d& p_TE = Eigen::Vector2d::Zero());

 private:
  void begin_target();
  ServoStep measure(const TipPose& target, int iteration);
  /// Returns how the motion ended, or nothing while the loop should continue.
  std::optional<ServoStatus> verdict(const std::vector<ServoStep>& steps) const;
  bool points_right(const ServoStep& step) const;
  /// Returns whether another correction is not expected to end nearer to the target.
  bool hopeless(const ServoStep& step) const;
  /// Says what is doubtful about a step's look, and keeps the look for the next one.
  std::optional<Doubt> doubt_of(const ServoStep& step);
  /// Adds a step's look to the estimate. Says what all looks together make doubtful about the cell.
  std::optional<Doubt> estimate(ServoStep& step);
  JointPlan corrected_joints(const ServoStep& step) const;
  /// Returns whether a stray of the arm may explain a doubt; not once the arm has come again.
  bool may_have_strayed(const Doubt& found, const ServoStep& step) const;
  /// Moves the arm away from a target that it is to approach again, where that is allowed.
  std::optional<Obstacle> withdraw();
  /// Moves and settles. Returns what forbids or stops the motion, if anything does.
  std::optional<Obstacle> command(const Joints& theta);
  /// Returns the longest way that one pulse of motor 1 or 2 moves the end point, metres.
  double pulse_size_m() const;

  ServoSettings settings_;
  GuardLimits limits_;
  JointPlanner planner_;
  PlanarRobot& robot_;
  TipSensor& sensor_;
  Clock& clock_;
  LandingModel* landings_;
  std::optional<LandingEstimator> estimator_;
  Eigen::Vector2d p_TE_{0.0, 0.0};        ///< of the present target
  double arrived_s_{0.0};                 ///< when the last motion came to rest
  std::optional<GuardedLook> last_look_;  ///< the last one that was not doubted
};

}  // namespace planar
