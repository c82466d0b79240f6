#include "device_host/hosted_arm.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_drive.h"

namespace planar::test {
namespace {

constexpr std::uint8_t kVendorOut = 0x40;
constexpr std::uint8_t kHaltAndSetPosition = 0xec;
constexpr std::uint8_t kSoftErrorResponse = 0x53, kHaltAndHold = 1;
/// A motor that was still within this time may be at rest; a slower one turns less than a pulse.
constexpr double kRest_s = 0.02;
constexpr double kBeyondLimit = 1.0 * kDegree;
constexpr double kTowardsSwitch_hz = 50000.0, kAwayFromSwitch_hz = 2000.0;  // pulses

}  // namespace

const std::array<std::string, 3>& HostedArm::serials() {
  static const std::array<std::string, 3> serials{"00410001", "00410002", "00410003"};
  return serials;
}

HostedArm::HostedArm(const CellSettings& cell, double age_s)
    : live_(read_truth(cell.truth.value()), virtual_hardware(cell), age_s) {
  const Transmission transmission(cell.transmission);
  const Pulses home = transmission.pulses_from_joints(cell.arm.home);
  home_pulses_ = {home[0], home[1], home[2]};
  teach_home();
  fit_switches(cell.transmission, transmission.pulses_per_rad());
  live_.set_mover([this](VirtualCell& virtual_cell) {
    for (std::size_t i = 0; i < 3; ++i)
      virtual_cell.turn_motor(static_cast<int>(i), home_pulses_[i] + tics_[i].shaft_pulses());
  });
}

/// As somebody did before, with planar-jog; the rest of what the application sets is a Tic's
/// default.
void HostedArm::teach_home() {
  for (std::size_t i = 0; i < 3; ++i) {
    tics_[i].store_setting(kSoftErrorResponse, kHaltAndHold);
    const auto position = static_cast<std::uint32_t>(home_pulses_[i]);
    tics_[i].control({kVendorOut, kHaltAndSetPosition, static_cast<std::uint16_t>(position),
                      static_cast<std::uint16_t>(position >> 16), 0},
                     nullptr);
  }
}

void HostedArm::fit_switches(const TransmissionSettings& transmission,
                             const Eigen::Vector3d& pulses_per_rad) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d ends_pulses =
        pulses_per_rad[static_cast<int>(i)] *
        (transmission.limits_rad[i] + Eigen::Vector2d(-kBeyondLimit, kBeyondLimit));
    const auto reverse_pulses = static_cast<std::int32_t>(std::lround(ends_pulses.minCoeff()));
    tics_[i].place_switches(reverse_pulses - home_pulses_[i], std::nullopt);
    tics_[i].set_homing_speeds(kTowardsSwitch_hz, kAwayFromSwitch_hz);
  }
}

cv::Mat HostedArm::expose(const cv::Rect& region_px, double brightness) {
  const double t_s = clock_.now_s();
  const TipPose tip = live_.true_tip();
  {
    const std::lock_guard lock(mutex_);
    true_tips_.push_back({t_s, tip});
  }
  return live_.expose(region_px, brightness);
}

bool HostedArm::moving() {
  live_.true_tip();
  return last_motion_s() > clock_.now_s() - kRest_s;
}

double HostedArm::last_motion_s() {
  return std::max({tics_[0].last_motion_s(), tics_[1].last_motion_s(), tics_[2].last_motion_s()});
}

std::vector<TrueTip> HostedArm::true_tips() {
  const std::lock_guard lock(mutex_);
  return true_tips_;
}

}  // namespace planar::test
