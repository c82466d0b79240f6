#include "planar_servo/offline/pairs/recorded_drift.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

namespace planar {
namespace {

Eigen::Vector2d middle_of(const SeenPlace& seen) {
  return 0.5 * (seen.place.lamps_B[0] + seen.place.lamps_B[1]);
}

/// Returns the visits of each place, told by its commanded joints.
std::vector<std::vector<const SeenPlace*>> visits(const std::vector<SeenPlace>& seen) {
  constexpr double kSame = 1e-7;  // radians
  std::map<std::tuple<long, long, long>, std::vector<const SeenPlace*>> by_joints;
  for (const SeenPlace& place : seen) {
    const auto step = [&](int joint) { return std::lround(place.place.theta[joint] / kSame); };
    by_joints[{step(0), step(1), step(2)}].push_back(&place);
  }
  std::vector<std::vector<const SeenPlace*>> places;
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

}  // namespace

Eigen::Vector2d recorded_drift(const std::vector<SeenPlace>& seen) {
  constexpr double kLeastFreedom = 6.0, kClearly = 5.0;  // standard deviations
  Trend trend;
  for (const auto& visited : visits(seen)) trend.add(visited);
  if (trend.freedom < kLeastFreedom || trend.tt == 0.0) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d slope = trend.tr / trend.tt;
  const double left = trend.rr - trend.tt * slope.squaredNorm();
  const double sigma = std::sqrt(std::max(0.0, left) / trend.freedom / trend.tt);
  return slope.norm() > kClearly * sigma ? slope : Eigen::Vector2d::Zero();
}

void bring_to_end(const std::vector<SeenPlace>& seen, std::vector<HealthPlace>& places) {
  const Eigen::Vector2d drift = recorded_drift(seen);
  std::map<std::string, double> times_s;
  double end_s = -HUGE_VAL;
  for (const SeenPlace& place : seen) {
    times_s[place.place.id] = place.t_s;
    end_s = std::max(end_s, place.t_s);
  }
  for (HealthPlace& place : places)
    for (Eigen::Vector2d& lamp_B : place.lamps_B) lamp_B += drift * (end_s - times_s.at(place.id));
}

}  // namespace planar
