#include "planar_servo/served_cell/drives/motor_trail.h"

namespace planar {

void MotorTrail::add(const Pulses& pulses) {
  const std::lock_guard lock(mutex_);
  if (places_.size() >= 2) {
    const Pulses before = places_.back() - places_[places_.size() - 2];
    const Pulses now = pulses - places_.back();
    if (before.cwiseSign().cwiseProduct(now.cwiseSign()).minCoeff() >= 0) places_.pop_back();
  }
  places_.push_back(pulses);
}

std::vector<MotorTrail::Pulses> MotorTrail::take() {
  const std::lock_guard lock(mutex_);
  std::vector<Pulses> taken = places_;
  if (!places_.empty()) places_.erase(places_.begin(), places_.end() - 1);
  return taken;
}

}  // namespace planar
