#include "planar_servo/virtual_cell/motion/motion_profile.h"

#include <algorithm>
#include <cmath>

namespace planar {
namespace {

MotionState after(const MotionState& start, double acceleration, double duration_s) {
  return {start.position + (start.velocity + 0.5 * acceleration * duration_s) * duration_s,
          start.velocity + acceleration * duration_s};
}

}  // namespace

MotionProfile::MotionProfile(double start_s, const MotionState& start, double target,
                             const MotionLimits& limits)
    : end_(start), end_s_(start_s) {
  const double a = limits.acceleration;
  const double stop = start.position + start.velocity * std::abs(start.velocity) / (2.0 * a);
  const double sign = target >= stop ? 1.0 : -1.0;
  if (sign * start.velocity < 0.0) {
    append(sign * a, std::abs(start.velocity) / a);
    end_.velocity = 0.0;
  }
  const double speed = std::abs(end_.velocity);
  const double distance = std::abs(target - end_.position);
  const double peak = std::min(limits.speed, std::sqrt(a * distance + 0.5 * speed * speed));
  const double ramps = (std::abs(peak * peak - speed * speed) + peak * peak) / (2.0 * a);
  append(std::copysign(a, sign * (peak - speed)), std::abs(peak - speed) / a);
  if (peak > 0.0) append(0.0, std::max(0.0, distance - ramps) / peak);
  append(-sign * a, peak / a);
  end_ = {target, 0.0};
}

void MotionProfile::append(double acceleration, double duration_s) {
  phases_.push_back({end_s_, end_, acceleration});
  end_ = after(end_, acceleration, duration_s);
  end_s_ += duration_s;
}

MotionState MotionProfile::state_at(double t_s) const {
  if (t_s >= end_s_) return end_;
  const auto next = std::find_if(phases_.begin(), phases_.end(),
                                 [&](const Phase& phase) { return phase.start_s > t_s; });
  const Phase& phase = *(next == phases_.begin() ? next : next - 1);
  return after(phase.start, phase.acceleration, std::max(0.0, t_s - phase.start_s));
}

std::vector<double> MotionProfile::turning_points(double from_s, double to_s) const {
  std::vector<double> positions;
  for (const Phase& phase : phases_)
    if (phase.start_s > from_s && phase.start_s <= to_s) positions.push_back(phase.start.position);
  if (end_s_ > from_s && end_s_ <= to_s) positions.push_back(end_.position);
  return positions;
}

}  // namespace planar
