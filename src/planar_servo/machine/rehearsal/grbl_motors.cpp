#include "planar_servo/machine/rehearsal/grbl_motors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Grbl 1.1 steps some 60 ms behind what it has planned, by which it must have motion for longer.
constexpr double kLongestBraking_s = 0.15, kLongestFirmwareBraking_s = 0.07;
constexpr double kSpeedStep_deg_s = 1e-3;
constexpr double kHomingFeed_mm_min = 6000.0;
constexpr int kStepIdleDelay = 1, kHomingEnabled = 22, kHomingDirections = 23, kHomingFeed = 25,
              kPulsesPerMm = 100, kMaxRate = 110, kAcceleration = 120;

EmulatedGrbl::Settings board_settings(const TransmissionSettings& transmission, bool firmware) {
  EmulatedGrbl::Settings settings{{kStepIdleDelay, 255}};
  const Eigen::Vector3d pulses_per_rad = Transmission(transmission).pulses_per_rad();
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& motor = transmission.drives[static_cast<std::size_t>(i)];
    const double mm_per_rad = std::abs(pulses_per_rad[i]) / kServedPulsesPerMm;
    settings[kPulsesPerMm + i] = kServedPulsesPerMm;
    settings[kMaxRate + i] = 60.0 * mm_per_rad * served_speed_deg_s(motor, firmware) * kDegree;
    settings[kAcceleration + i] = mm_per_rad * motor.max_acceleration_rad_s2;
  }
  return settings;
}

EmulatedGrbl::Settings with_switches(EmulatedGrbl::Settings settings) {
  settings[kHomingEnabled] = 1;
  settings[kHomingDirections] = 7;
  settings[kHomingFeed] = kHomingFeed_mm_min;
  return settings;
}

void require_real_time(const std::filesystem::path& firmware, const std::string& banner) {
  if (banner.rfind("Grbl 1.1", 0) == 0) return;
  throw WorkError(
      {fmt::format("{} is '{}', whose simulator takes 20 ms for each byte, too slow for real time",
                   firmware.string(), banner),
       "name the simulator of Grbl 1.1"});
}

}  // namespace

double served_speed_deg_s(const MotorDrive& motor, bool firmware) {
  const double longest =
      (firmware ? kLongestFirmwareBraking_s : kLongestBraking_s) * motor.max_acceleration_rad_s2;
  const double speed_deg_s = std::min(motor.max_speed_rad_s, longest) / kDegree;
  // A value that a file rounds up to the next step in its last digit is that step.
  return kSpeedStep_deg_s * std::floor(speed_deg_s / kSpeedStep_deg_s + 1e-6);
}

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

GrblMotors::GrblMotors(const CellSettings& cell, const std::filesystem::path& port, LiveCell& live,
                       const std::optional<std::filesystem::path>& firmware)
    : live_(live), home_(Transmission(cell.transmission).pulses_from_joints(cell.arm.home)) {
  const EmulatedGrbl::Settings settings = board_settings(cell.transmission, firmware.has_value());
  const auto on_position = [this](const EmulatedGrbl::Pulses& shafts) { trail_.add(shafts); };
  if (firmware) {
    firmware_.emplace(*firmware, std::vector<std::string>{}, settings, port, on_position);
    require_real_time(*firmware, firmware_->banner());
  } else {
    emulated_.emplace(port, with_switches(settings), on_position);
    emulated_->place_switches(Eigen::Vector3d::Zero());
  }
  live_.set_mover([this](VirtualCell& virtual_cell) { follow(virtual_cell); });
}

GrblMotors::~GrblMotors() {
  live_.set_mover({});
}

void GrblMotors::follow(VirtualCell& virtual_cell) {
  for (const MotorTrail::Pulses& counted : trail_.take()) {
    counted_ = counted;
    for (int i = 0; i < 3; ++i) virtual_cell.turn_motor(i, home_[i] + counted_[i] - at_marks_[i]);
  }
}

bool GrblMotors::put_at_marks() {
  if (!firmware_) return false;
  return live_.now([this](VirtualCell& virtual_cell) {
    if (!firmware_->rests()) return false;
    at_marks_ = counted_;
    for (int i = 0; i < 3; ++i) virtual_cell.turn_motor(i, home_[i]);
    return true;
  });
}

void GrblMotors::require_well() const {
  if (firmware_) firmware_->require_well();
}

}  // namespace planar
