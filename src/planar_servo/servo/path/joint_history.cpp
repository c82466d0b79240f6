#include "planar_servo/servo/path/joint_history.h"

#include <algorithm>
#include <stdexcept>

namespace planar {
namespace {

/// A picture that arrives later than this is of no use to a motion, seconds.
constexpr double kRemembered_s = 2.0;

}  // namespace

void JointHistory::add(double t_s, const Joints& theta) {
  samples_.push_back({t_s, theta});
  while (samples_.front().t_s < t_s - kRemembered_s) samples_.pop_front();
}

Joints JointHistory::at(double t_s) const {
  if (samples_.empty()) throw std::logic_error("no joints were taken");
  const auto after = std::find_if(samples_.begin(), samples_.end(),
                                  [&](const Sample& sample) { return sample.t_s >= t_s; });
  if (after == samples_.end()) return samples_.back().theta;
  if (after == samples_.begin()) return after->theta;
  const Sample& before = *(after - 1);
  const double share = (t_s - before.t_s) / (after->t_s - before.t_s);
  return before.theta + share * (after->theta - before.theta);
}

}  // namespace planar
