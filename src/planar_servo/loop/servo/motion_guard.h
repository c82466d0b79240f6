#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/loop/servo/servo_result.h"

namespace planar {

/// Returns the stops, in order, of an arm that arrives at these joint angles: there alone, or first
/// short of them by the settings' approach margin in every motor.
std::vector<Joints> approach_stops(const Transmission& transmission, const ServoSettings& settings,
                                   const Joints& theta);
/// The rests of a way to a place, or why there is none.
struct ApproachWay {
  std::vector<Joints> stops;  ///< the last is at the place; valid without a refusal
  std::optional<std::string> refusal{};
  /// Why the straight way is barred, where the way goes round.
  std::optional<std::string> barred{};
};

/// Returns the way from rest at `from` to `theta`: straight, or round the barriers, where motor 1
/// may end on another turn. Refused is what the planner forbids and where no way leads.
ApproachWay approach_way(const JointPlanner& planner, const ServoSettings& settings,
                         const Joints& from, const Joints& theta);

/// Returns its refusal.
inline std::optional<std::string> approach_refusal(const JointPlanner& planner,
                                                   const ServoSettings& settings,
                                                   const Joints& from, const Joints& theta) {
  return approach_way(planner, settings, from, theta).refusal;
}

/// Returns by how much play may move the end point when motors arrive from either side, metres: the
/// settings' approach margin, which exceeds the play, at full reach.
double play_allowance_m(const PlanarArm& arm, const ServoSettings& settings);

/// Says what kept the arm from arriving.
struct Obstacle {
  bool refused{false};  ///< the move is forbidden; else the guard stopped the arm on the way
  std::string reason;
};

/// Moves the arm to these joints as the settings say: straight, or with every motor from the same
/// side. Nothing moves when the planner refuses the joints, the place short of them or the way
/// there. Throws what PlanarRobot::move_to() throws.
std::optional<Obstacle> arrive(PlanarRobot& robot, const JointPlanner& planner,
                               const ServoSettings& settings, const Joints& theta,
                               const PlanarRobot::Guard& guard);

/// Does so by a way from where the arm rests.
std::optional<Obstacle> arrive_by(const ApproachWay& way, PlanarRobot& robot,
                                  const PlanarRobot::Guard& guard);

/// The longest wait for a camera that fails.
constexpr double kCameraPatience_s = 60.0;

/// Waits, with the arm at rest, until the camera delivers properly again, and logs it. `id` names
/// what is to be continued, `reason` what is wrong. Returns false once the clock is past
/// `deadline_s`. Throws what PlanarRobot::throw_if_stopped() throws.
bool wait_for_camera(const FrameSource& camera, const PlanarRobot& robot, Clock& clock,
                     const std::string& id, const std::string& reason, double deadline_s);

/// Holds what a calibrated cell promises about every look at its tool. The defaults of place,
/// direction and separation hold without a health record; see with_health().
struct GuardLimits {
  /// The tool is seen no farther than this from where it was commanded, and turned by no more.
  double distance_m{10e-3};
  double turn{3.0 * kDegree};
  /// The distance between the lamps on the plane, uncompensated, and how far it may be off.
  double separation_m{0.0};
  double separation_tolerance_m{std::numeric_limits<double>::infinity()};
  /// The error map corrects by no more than this.
  double correction_m{std::numeric_limits<double>::infinity()};
  /// What play and noise may add to a motion or take from it.
  double play_m{0.1e-3};
  /// By how much two stops may differ from their commands by scatter alone.
  double scatter_m{0.0};
  /// The greatest uncertainty, of two standard deviations, by which a look may move the arm.
  double noise_m{50e-6};
};

/// Returns the limits of a loop with this tolerance: where it exceeds the noise that is allowed,
/// looks need be no more certain than that, and may show as much more motion.
GuardLimits for_tolerance(GuardLimits limits, double tolerance_m);

/// Holds one look at the tool and what was commanded for it.
struct GuardedLook {
  TipMeasurement measurement;  ///< of a tool that was found
  TipPose commanded;           ///< by the arm's model, base frame
  double arrived_s{0.0};       ///< when the arm had come to rest
};

/// Says why a look must not move the arm.
struct Doubt : Refusal {
  bool of_cell{false};       ///< it holds for other targets, too
  bool may_be_stray{false};  ///< one stop that missed explains it: the arm may come again
};

/// Compares a look with the command and with what the cell promises: its age, its noise, the
/// lamps' distance, the tool's place and direction, the error map's correction, and the motion
/// since the look `before`, if there was one. Returns the first doubt.
std::optional<Doubt> doubt(const GuardLimits& limits, const GuardedLook& look,
                           const GuardedLook* before);

/// Returns true when the error grew in the last two looks at a target, and by more than `noise_m`
/// explains. `errors_m` are the errors at all looks, in their order.
bool diverges(const std::vector<double>& errors_m, double noise_m);

}  // namespace planar
