#include "planar_servo/servo/path/path_check.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/core/text.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// What the corrections are left of a drive's speed and acceleration.
constexpr double kShareForPath = 0.9;

/// Watches the motors from step to step.
class MotorWatch {
 public:
  explicit MotorWatch(const JointPlanner& planner) : planner_(planner) {}

  /// Takes the joints one step later. Returns which motor cannot keep up, in words.
  std::optional<std::string> objection(const Joints& theta, PathDemand& demand) {
    const Eigen::Vector3d motors = planner_.transmission().motors_from_joints(theta);
    const Eigen::Vector3d speeds =
        steps_ == 0 ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : (motors - motors_) / kPathStep_s;
    std::optional<std::string> objection;
    for (int i = 0; i < 3 && !objection; ++i) objection = objection_of(i, speeds[i], demand);
    motors_ = motors;
    speeds_ = speeds;
    ++steps_;
    return objection;
  }

 private:
  std::optional<std::string> objection_of(int i, double speed, PathDemand& demand) const {
    const MotorDrive& drive =
        planner_.transmission().settings().drives[static_cast<std::size_t>(i)];
    const double share = std::abs(speed) / drive.max_speed_rad_s;
    if (share > demand.speed_share) {
      demand.speed_share = share;
      demand.fastest_motor = i;
    }
    if (share > kShareForPath) return too_fast(i, "turn at", speed, drive.max_speed_rad_s, "deg/s");
    const double acceleration = (speed - speeds_[i]) / kPathStep_s;
    if (steps_ > 1 && std::abs(acceleration) > kShareForPath * drive.max_acceleration_rad_s2)
      return too_fast(i, "speed up by", acceleration, drive.max_acceleration_rad_s2, "deg/s^2");
    return std::nullopt;
  }

  static std::string too_fast(int i, const char* what, double asked, double most,
                              const char* unit) {
    return fmt::format(
        "motor {} would have to {} {:.1f} {}; on a path it does at most {:.1f} {}: "
        "ask for a lower speed, or lead the path farther away from the base",
        i + 1, what, std::abs(asked) / kDegree, unit, kShareForPath * most / kDegree, unit);
  }

  const JointPlanner& planner_;
  int steps_{0};
  Eigen::Vector3d motors_{0.0, 0.0, 0.0}, speeds_{0.0, 0.0, 0.0};
};

}  // namespace

PathDemand path_demand(const JointPlanner& planner, const Path& path, const PathTiming& timing,
                       const Joints& near) {
  PathDemand demand;
  MotorWatch watch(planner);
  Joints theta = near;
  const auto steps = static_cast<int>(std::ceil(timing.duration_s() / kPathStep_s));
  for (int i = 0; i <= steps; ++i) {
    const double along_m = timing.along_m(i * kPathStep_s);
    const TipPose pose = path.at(along_m).pose;
    const JointPlan plan = planner.plan(pose, theta);
    theta = plan.theta;
    if (i == 0) demand.start = theta;
    demand.refusal = plan.refusal;
    if (!demand.refusal) demand.refusal = watch.objection(theta, demand);
    if (!demand.refusal) continue;
    demand.refusal = fmt::format("{:.1f} mm along the path, at {}: {}", mm(along_m),
                                 place_mm(pose.p), *demand.refusal);
    break;
  }
  return demand;
}

}  // namespace planar
