#include "planar_servo/hardware/drives/jog_path.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "planar_servo/geometry/arm/transmission.h"
#include "planar_servo/hardware/drives/grbl_protocol.h"

namespace planar {
namespace {

/// The shortest piece, as time at full speed; shorter ones would only load the line.
constexpr double kShortestPiece_s = 0.02;

}  // namespace

double reach(double speed, double top_speed, double acceleration, double duration) {
  const double peak = std::min(top_speed, (acceleration * duration + speed) / 2.0);
  const double changing_s = (2.0 * peak - speed) / acceleration;
  const double changing_way = (2.0 * peak * peak - speed * speed) / (2.0 * acceleration);
  return changing_way + peak * std::max(0.0, duration - changing_s);
}

JogPath::JogPath(const AxisPulses& from, const AxisPulses& to,
                 const std::array<AxisLimits, 3>& limits)
    : from_(from),
      to_(to),
      sent_(from),
      pulses_per_mm_(limits[0].pulses_per_mm, limits[1].pulses_per_mm, limits[2].pulses_per_mm) {
  const Eigen::Vector3d way = in_mm(to) - in_mm(from);
  length_ = way.norm();
  if (length_ == 0.0) return;
  direction_ = way / length_;
  const auto& [x, y, z] = limits;
  const StraightPace pace =
      straight_pace(direction_, {x.speed_mm_s, y.speed_mm_s, z.speed_mm_s},
                    {x.acceleration_mm_s2, y.acceleration_mm_s2, z.acceleration_mm_s2});
  speed_ = pace.speed;
  acceleration_ = pace.acceleration;
}

Eigen::Vector3d JogPath::in_mm(const AxisPulses& pulses) const {
  return pulses.cast<double>().cwiseQuotient(pulses_per_mm_);
}

std::optional<AxisPulses> JogPath::next_piece(const AxisPulses& here) {
  if (all_sent()) return std::nullopt;
  // Before its beginning lies the rest of another way, of known distance.
  const Eigen::Vector3d since = in_mm(here) - in_mm(from_);
  const double along = direction_.dot(since);
  const double passed = along - (since - along * direction_).norm();
  const double speed = std::min(speed_, std::sqrt(2.0 * acceleration_ * std::max(0.0, passed)));
  const double allowed =
      std::min(length_, passed + reach(speed, speed_, acceleration_, grbl::kLongestRun_s));
  if (allowed < length_ && allowed - sent_length_ < speed_ * kShortestPiece_s) return std::nullopt;
  sent_length_ = allowed;
  const Eigen::Vector3d end_mm = in_mm(from_) + direction_ * allowed;
  sent_ = allowed == length_
              ? to_
              : AxisPulses(end_mm.cwiseProduct(pulses_per_mm_).array().round().cast<int>());
  return sent_;
}

bool JogPath::leads_to(const AxisPulses& target, const AxisPulses& here) const {
  const AxisPulses ahead = sent_ - here, further = target - sent_;
  for (int i = 0; i < 3; ++i)
    if (std::int64_t{ahead[i]} * further[i] < 0) return false;
  return true;
}

}  // namespace planar
