#include "planar_servo/virtual_cell/motion/motor_warmth.h"

#include <algorithm>
#include <cmath>

namespace planar {
namespace {

constexpr double kRegularShare = 0.3, kRegular_s = 3600.0;

}  // namespace

MotorWarmth::MotorWarmth(const ArmWarmingTruth& truth) : truth_(truth) {
  const double heat = kRegularShare + (1.0 - kRegularShare) * truth.holding_share;
  regular_ = after({}, heat, kRegular_s);
}

void MotorWarmth::work(double t_s, double turns_until_s, bool energized) {
  last_ = warmed(t_s);
  last_s_ = t_s;
  turns_until_s_ = turns_until_s;
  holding_ = energized ? truth_.holding_share : 0.0;
}

Warmth MotorWarmth::at(double t_s) const {
  const Warmth now = warmed(t_s);
  return {now.motor / regular_.motor, now.link / regular_.link};
}

Warmth MotorWarmth::warmed(double t_s) const {
  const double rests_s = std::clamp(turns_until_s_, last_s_, t_s);
  return after(after(last_, 1.0, rests_s - last_s_), holding_, t_s - rests_s);
}

Warmth MotorWarmth::after(const Warmth& from, double heat, double duration_s) const {
  const double motor_left = std::exp(-duration_s / truth_.motor_time_s);
  const double link_left = std::exp(-duration_s / truth_.link_time_s);
  const double behind = from.motor - heat;
  const double led = behind * truth_.motor_time_s / (truth_.motor_time_s - truth_.link_time_s);
  return {heat + behind * motor_left,
          heat + (from.link - heat - led) * link_left + led * motor_left};
}

}  // namespace planar
