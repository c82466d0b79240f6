#pragma once

#include <Eigen/Core>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/loop/servo/path/path.h"
#include "planar_servo/loop/servo/position_servo.h"
#include "planar_servo/loop/servo/servo_result.h"

namespace planar {

/// The play of each motor's gear while an arm moves to and fro. A gear that was turned upwards last
/// stands where the arm's model has it; turned downwards, it stands higher by its play.
class GearPlay {
 public:
  /// Takes the play (radians, behind the gear) and joints at which all motors came from below.
  GearPlay(const Transmission& transmission, const Eigen::Vector3d& play_rad, const Joints& theta);
  /// Takes the joints as the drives stand now. Returns those behind the play. Call it so often that
  /// no motor turns back in between (the play operator).
  Joints behind(const Joints& drives);
  /// Returns the joints to command for those behind the play to come to `wanted`, which moves.
  Joints command(const Joints& wanted);

 private:
  const Transmission& transmission_;
  Eigen::Vector3d play_;
  Eigen::Vector3d held_;     ///< motors' angles behind the play
  Eigen::Vector3d extreme_;  ///< the farthest that each motor was wanted on its present way
  Eigen::Vector3d side_{1.0, 1.0, 1.0};  ///< +1 for a motor on its way up, -1 down
};

/// Holds what was found of the motors' play.
struct PlayProbe {
  /// Of motors 1 and 2, radians behind the gear; 0 for motor 3: the end point does not show it.
  std::optional<Eigen::Vector3d> play_rad{};
  std::string unknown{};  ///< why there is no play, in words
  /// What kept the arm from returning, from below, to where it rested, if anything did.
  std::optional<Obstacle> not_back{};
};

/// Measures the play where the arm rests: it arrives there with every motor from above and then
/// from below, and looks each time. Nothing moves where the arm must not do that. Looks that differ
/// by more than the approach margin tell nothing. Throws what PlanarRobot::move_to() throws.
PlayProbe measure_play(PlanarRobot& robot, const JointPlanner& planner,
                       const ServoSettings& settings, TipSensor& sensor, Clock& clock);

/// Holds what a path demands of the motors, or why it must not be followed.
struct PathDemand {
  std::optional<std::string> refusal;  ///< in words, with the place on the path
  Joints start{0.0, 0.0, 0.0};         ///< where it begins
  /// The greatest share of its speed that a motor needs, and which motor that is.
  double speed_share{0.0};
  int fastest_motor{0};  ///< counts from 0
};

/// Follows the path without moving, in steps of kPathStep_s, from joints near to `near`, or from
/// another turn of the motors where these would come to the end of their limits on the way. It
/// refuses what the planner refuses, and motors that would have to be faster, or to speed up
/// faster, than their drives do; a tenth of both is kept for the corrections.
PathDemand path_demand(const JointPlanner& planner, const Path& path, const PathTiming& timing,
                       const Joints& near);

/// The time from one command to the next, seconds.
constexpr double kPathStep_s = 0.02;

/// Remembers for a while where the drives stood, to compare a picture with the joints then.
class JointHistory {
 public:
  /// Takes the joints at a time that is not before those taken already, seconds.
  void add(double t_s, const Joints& theta);
  /// Returns the joints at a time, interpolated, held at the ends; std::logic_error for none.
  Joints at(double t_s) const;

 private:
  struct Sample {
    double t_s;
    Joints theta;
  };
  std::deque<Sample> samples_;
};

/// Records one look at the tool while it moves.
struct PathLook {
  double t_s{0.0};      ///< the middle of the exposure, since the path was begun
  double along_m{0.0};  ///< how far along the path the end point should have been then
  TipPose desired;      ///< the place there
  TipMeasurement measurement;
  PathOffset seen;                       ///< where it was seen; valid with the measurement
  Joints theta{0.0, 0.0, 0.0};           ///< joints then, by the drives' counts and the play known
  Eigen::Vector2d correction{0.0, 0.0};  ///< added to the path from now on
  double along_now_m{0.0};               ///< how far along it should be when this is reported
};

struct PathResult {
  ServoStatus status{ServoStatus::kReached};
  std::string reason{};       ///< in words; empty when the path's end was reached
  bool cell_in_doubt{false};  ///< as in ServoResult
  double duration_s{0.0};
};

/// When a camera's pictures are exposed.
struct ExposureTiming {
  double period_s{0.0};    ///< from the beginning of one exposure to that of the next
  double exposure_s{0.0};  ///< a moving lamp is seen where it was in the middle of this time
};

/// Guides the end point along a path. The joints follow the inverse kinematics of the arm that was
/// found, by velocities; a motor that reverses first crosses its play. Each look while moving is
/// compared with the joints at its exposure: what the arm missed there, d = p - reached(theta), is
/// a disturbance that changes slowly, and the path minus d is commanded. As d does not depend on
/// the command, a late picture makes the correction late but never unstable.
class PathFollower {
 public:
  using Observer = std::function<void(const PathLook&)>;

  /// Takes robot, sensor and clock, which must outlive the follower.
  PathFollower(const ServoSettings& settings, const GuardLimits& limits,
               const JointPlanner& planner, PlanarRobot& robot, TipSensor& sensor, Clock& clock,
               const ExposureTiming& exposures);
  /// Sets the play of the motors' gears, radians; it is 0 at first.
  void set_play(const Eigen::Vector3d& play_rad) { play_rad_ = play_rad; }
  /// Follows the path from its beginning, where the arm has arrived from below; reports every look.
  /// Without `by_vision` they correct nothing. The arm slows down to rest when the camera fails, no
  /// lamps are seen for kLongestBlind_s, a look is doubted, or the drives fall behind. Throws what
  /// PlanarRobot::turn() does.
  PathResult follow(const Path& path, const PathTiming& timing, bool by_vision,
                    const Observer& observer = {});

  static constexpr double kLongestBlind_s{0.5};

 private:
  /// One way along a path. Times are those of the clock.
  struct Run {
    const Path& path;
    const PathTiming& timing;
    bool by_vision;
    double start_s;
    double seen_s;  ///< when the tool was seen last
    Joints near;    ///< the joints wanted last, which choose the turns of the motors
    GearPlay play;
    double commanded_s{0.0};  ///< when the joints were commanded last
    double waited_s{0.0};     ///< for how long the path has waited for an arm that slowed down
    double exposed_s{0.0};    ///< when the exposure of the last picture began
    JointHistory history{};   ///< of the joints behind the play
    std::optional<Eigen::Vector2d> disturbance{};
    std::optional<GuardedLook> last_look{};
    bool inside_map{true};

    double along_m(double t_s) const { return timing.along_m(t_s - start_s - waited_s); }
    Eigen::Vector2d correction() const;
  };

  std::optional<PathResult> move_along(Run& run, const Observer& observer);
  void brake_after_fault();
  /// Looks once and learns from it. Returns why the path ends here, if it does.
  std::optional<PathResult> look(Run& run, const Observer& observer);
  PathLook measure(Run& run);
  std::optional<PathResult> objection(Run& run, const PathLook& look) const;
  /// Lets the joints continue until the next exposure is about to begin.
  std::optional<PathResult> move_until_exposure(Run& run);
  std::optional<PathResult> command(Run& run);
  /// Returns why the path ends where the drives do not follow what they are told.
  std::optional<PathResult> left_behind(const Run& run, const Joints& wanted, double now_s) const;
  /// Returns the joints that bring the end point, corrected, to its place at a time.
  JointPlan joints_at(const Run& run, double t_s) const;
  /// Reads where the drives stand now.
  Joints take_joints(Run& run);

  Eigen::Vector3d play_rad_{0.0, 0.0, 0.0};
  GuardLimits limits_;
  JointPlanner planner_;
  PlanarRobot& robot_;
  TipSensor& sensor_;
  Clock& clock_;
  ExposureTiming exposures_;
};

}  // namespace planar
