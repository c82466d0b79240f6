#include "planar_servo/servo/path/path_timing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// Two segments that meet at a smaller angle are passed without a rest.
constexpr double kSmoothJoint = 1.0 * kDegree;

double top_speed(const PathSegment& segment, double speed, double acceleration) {
  if (segment.curvature() == 0.0) return speed;
  return std::min(speed, std::sqrt(acceleration / segment.curvature()));
}

bool joined_smoothly(const PathSegment& before, const PathSegment& after) {
  const Eigen::Vector2d in = before.at(before.length_m()).tangent, out = after.at(0.0).tangent;
  return std::abs(std::atan2(cross2d(in, out), in.dot(out))) < kSmoothJoint;
}

/// Returns the speed at the beginning of each segment and at the end of the last one.
std::vector<double> joint_speeds(const std::vector<PathSegment>& segments,
                                 const std::vector<double>& tops, double acceleration) {
  const std::size_t n = segments.size();
  std::vector<double> speeds(n + 1, 0.0);
  for (std::size_t i = 1; i < n; ++i)
    if (joined_smoothly(segments[i - 1], segments[i])) speeds[i] = std::min(tops[i - 1], tops[i]);
  const auto reachable = [&](double from, std::size_t i) {
    return std::sqrt(from * from + 2.0 * acceleration * segments[i].length_m());
  };
  for (std::size_t i = 0; i < n; ++i)
    speeds[i + 1] = std::min(speeds[i + 1], reachable(speeds[i], i));
  for (std::size_t i = n; i-- > 0;) speeds[i] = std::min(speeds[i], reachable(speeds[i + 1], i));
  return speeds;
}

}  // namespace

PathTiming::PathTiming(const Path& path, double speed_m_s, double acceleration_m_s2)
    : acceleration_(acceleration_m_s2) {
  if (!(speed_m_s > 0.0) || !(acceleration_m_s2 > 0.0) || !std::isfinite(speed_m_s))
    throw std::invalid_argument("a path's speed and acceleration must be positive");
  std::vector<double> tops;
  for (const PathSegment& segment : path.segments())
    tops.push_back(top_speed(segment, speed_m_s, acceleration_m_s2));
  const std::vector<double> speeds = joint_speeds(path.segments(), tops, acceleration_m_s2);
  for (std::size_t i = 0; i < tops.size(); ++i)
    append(path.segments()[i].length_m(), speeds[i], speeds[i + 1], tops[i]);
}

void PathTiming::append(double length_m, double from, double to, double top) {
  const double a = acceleration_;
  const double peak = std::min(top, std::sqrt(a * length_m + 0.5 * (from * from + to * to)));
  const double ramps_m = (2.0 * peak * peak - from * from - to * to) / (2.0 * a);
  append_phase((peak - from) / a, from, a);
  append_phase(std::max(0.0, length_m - ramps_m) / peak, peak, 0.0);
  append_phase((peak - to) / a, peak, -a);
}

void PathTiming::append_phase(double duration_s, double speed_m_s, double acceleration_m_s2) {
  phases_.push_back({end_s_, end_m_, speed_m_s, acceleration_m_s2});
  end_m_ += (speed_m_s + 0.5 * acceleration_m_s2 * duration_s) * duration_s;
  end_s_ += duration_s;
}

double PathTiming::along_m(double t_s) const {
  if (t_s >= end_s_) return end_m_;
  const auto next =
      std::upper_bound(phases_.begin() + 1, phases_.end(), t_s,
                       [](double t, const Phase& phase) { return t < phase.begin_s; });
  const Phase& phase = *(next - 1);
  const double dt = std::max(0.0, t_s - phase.begin_s);
  return phase.begin_m + (phase.speed_m_s + 0.5 * phase.acceleration_m_s2 * dt) * dt;
}

}  // namespace planar
