#include "planar_servo/cameras/aravis/camera_clock.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace planar {
namespace {

// Crystals are good to 100 ppm, and a steady clock that is being disciplined may be off by 500 ppm.
constexpr double kDrift = 600e-6;

}  // namespace

void CameraClock::begin_stream(double start_s) {
  start_s_ = start_s;
}

double CameraClock::due_s(double device_s, double arrival_s) {
  if (!std::isfinite(device_s) || !std::isfinite(arrival_s))
    throw std::invalid_argument("CameraClock::due_s: a time is not finite");
  const double offset_s = arrival_s - device_s;
  const bool advances = last_device_s_ && device_s > *last_device_s_;
  offset_s_ =
      advances ? std::min(offset_s, offset_s_ + kDrift * (device_s - *last_device_s_)) : offset_s;
  last_device_s_ = device_s;
  const double due_s = std::min(device_s + offset_s_, arrival_s);
  const auto start_s = std::exchange(start_s_, std::nullopt);
  if (start_s && due_s < *start_s) believed_ = false;
  return believed_ ? due_s : arrival_s;
}

}  // namespace planar
