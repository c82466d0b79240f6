#include "planar_servo/offline/pairs/health_of_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/health/health_check.h"
#include "planar_servo/offline/pairs/pair_tracker.h"

namespace planar {
namespace {

Eigen::Vector2d middle_of(const SeenPlace& seen) {
  return 0.5 * (seen.place.lamps_B[0] + seen.place.lamps_B[1]);
}

/// Returns the visits of each place, told apart by the commanded joints.
std::vector<std::vector<const SeenPlace*>> visits(const std::vector<SeenPlace>& seen) {
  constexpr double kSame = 1e-7;  // radians
  std::map<std::tuple<long, long, long>, std::vector<const SeenPlace*>> by_joints;
  for (const SeenPlace& place : seen) {
    const auto step = [&](int joint) { return std::lround(place.place.theta[joint] / kSame); };
    by_joints[{step(0), step(1), step(2)}].push_back(&place);
  }
  std::vector<std::vector<const SeenPlace*>> places;
  places.reserve(by_joints.size());
  for (auto& [joints, visited] : by_joints) places.push_back(std::move(visited));
  return places;
}

/// Sums over visits, each counted from the mean of its place's.
struct Trend {
  double tt{0.0}, rr{0.0};
  Eigen::Vector2d tr{0.0, 0.0};
  double freedom{-2.0};  // of both axes, less the two slopes

  void add(const std::vector<const SeenPlace*>& visited) {
    double mean_t = 0.0;
    Eigen::Vector2d mean(0.0, 0.0);
    const auto n = static_cast<double>(visited.size());
    for (const SeenPlace* visit : visited) {
      mean_t += visit->t_s / n;
      mean += middle_of(*visit) / n;
    }
    for (const SeenPlace* visit : visited) {
      const double t = visit->t_s - mean_t;
      const Eigen::Vector2d r = middle_of(*visit) - mean;
      tt += t * t;
      tr += t * r;
      rr += r.squaredNorm();
    }
    freedom += 2.0 * (n - 1.0);
  }
};

/// Returns how the lamps of each place looked in the last frame that says it.
std::map<std::string, LampLooks> last_looks(const std::vector<LampRow>& lamps) {
  std::map<std::string, LampLooks> looks;
  for (const LampRow& row : lamps)
    if (row.status == LampStatus::kOk && row.looks.size() == 2)
      looks[row.id] = {row.looks[0], row.looks[1]};
  return looks;
}

/// Places to be visited again lie within this of home in every motor: a visit of all takes 10 s at
/// most then.
constexpr double kNearHome = 100.0 * kDegree;
/// At so many places, evenly taken from a recording, the arm is compared with its file; more would
/// add nothing.
constexpr std::size_t kArmPlaces = 24;
/// The effect of eccentric reducers and an uncorrected lens over the whole field on the middle of
/// the lamps, and on their direction.
constexpr double kFieldSigma_m = 0.5e-3;
constexpr double kDirectionSigma_m = 0.05e-3;

}  // namespace

RecordedDrift recorded_drift(const std::vector<SeenPlace>& seen) {
  constexpr double kLeastFreedom = 6.0, kClearly = 5.0;  // standard deviations
  Trend trend;
  double since_s = HUGE_VAL;
  for (const auto& visited : visits(seen)) {
    trend.add(visited);
    if (visited.size() > 1)
      for (const SeenPlace* visit : visited) since_s = std::min(since_s, visit->t_s);
  }
  if (trend.freedom < kLeastFreedom || trend.tt == 0.0) return {};
  const Eigen::Vector2d slope = trend.tr / trend.tt;
  const double left = trend.rr - trend.tt * slope.squaredNorm();
  const double sigma = std::sqrt(std::max(0.0, left) / trend.freedom / trend.tt);
  if (slope.norm() <= kClearly * sigma) return {};
  return {slope, since_s};
}

void bring_to_end(const std::vector<SeenPlace>& seen, std::vector<HealthPlace>& places) {
  const RecordedDrift drift = recorded_drift(seen);
  std::map<std::string, double> times_s;
  double end_s = -HUGE_VAL;
  for (const SeenPlace& place : seen) {
    times_s[place.place.id] = place.t_s;
    end_s = std::max(end_s, place.t_s);
  }
  for (HealthPlace& place : places) {
    const double t_s = times_s.at(place.id);
    for (Eigen::Vector2d& lamp_B : place.lamps_B) lamp_B += drift.m_per_s * (end_s - t_s);
    const double extended_s = std::max(0.0, drift.since_s - t_s);
    place.sigma_m = std::hypot(place.sigma_m, drift.m_per_s.norm() * extended_s);
  }
}

std::vector<SeenPlace> seen_places(const CellSettings& cell, const VisionCalibration& vision,
                                   const std::vector<FrameRow>& frames,
                                   const std::vector<LampRow>& lamps) {
  const PlanarArm arm(cell.arm.geometry);
  std::vector<SeenPlace> seen;
  const std::map<std::string, LampLooks> looks = last_looks(lamps);
  for (const PoseSight& sight : unattended_sights(lamp_sights(lamps, frames)).unattended) {
    const auto place = see_tool(vision, sight);
    if (!place) continue;
    const double sigma_m = per_axis(place->seen.covariance);
    seen.push_back({{sight.id, sight.theta, place->seen.lamps_B, sigma_m},
                    sight.t_s,
                    arm.forward(sight.theta),
                    place->seen.tip});
    if (const auto look = looks.find(sight.id); look != looks.end())
      seen.back().looks = look->second;
  }
  return seen;
}

HealthRecord health_of(const CellSettings& cell, const std::vector<SeenPlace>& seen) {
  if (seen.size() < kHealthPlaces)
    throw InputError(
        {fmt::format("the recording has {} places with both lamps", seen.size()),
         fmt::format("a check of the cell's health needs {} of them to visit again", kHealthPlaces),
         "", Cause::kInsufficient});
  const Transmission transmission(cell.transmission);
  const Eigen::Vector3d home = transmission.motors_from_joints(cell.arm.home);
  const JointPlanner planner = joint_planner(cell);
  std::vector<SeenPlace> allowed, near;
  for (const SeenPlace& place : seen) {
    if (planner.refusal(place.place.theta)) continue;
    allowed.push_back(place);
    const Eigen::Vector3d motors = transmission.motors_from_joints(place.place.theta);
    if ((motors - home).cwiseAbs().maxCoeff() <= kNearHome) near.push_back(place);
  }
  HealthRecord record = health_record_of(seen);
  for (const auto* choice : {&allowed, &near})
    if (choice->size() >= kHealthPlaces) record.places = health_record_of(*choice).places;
  bring_to_end(seen, record.places);
  return record;
}

std::vector<HealthFinding> arm_faults(const CellSettings& cell, const VisionCalibration& vision,
                                      const std::vector<SeenPlace>& seen) {
  const Transmission transmission(cell.transmission);
  const std::size_t stride = std::max<std::size_t>(1, seen.size() / kArmPlaces);
  std::vector<ArmSight> sights;
  for (std::size_t i = 0; i < seen.size(); i += stride)
    sights.push_back({transmission.motors_from_joints(seen[i].place.theta), seen[i].place.lamps_B,
                      kFieldSigma_m, kDirectionSigma_m});
  return find_arm_faults(model_of_cell(joint_planner(cell), cell.arm.home, vision), sights);
}

}  // namespace planar
