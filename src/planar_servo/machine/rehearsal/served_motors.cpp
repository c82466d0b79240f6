#include "planar_servo/machine/rehearsal/served_motors.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Grbl 1.1 steps some 60 ms behind what it has planned, by which it must have motion for longer.
constexpr double kLongestBraking_s = 0.15, kLongestFirmwareBraking_s = 0.07;
constexpr double kSpeedStep_deg_s = 1e-3;
constexpr double kHomingFeed_mm_min = 6000.0;
constexpr int kStepIdleDelay = 1, kHomingEnabled = 22, kHomingDirections = 23, kHomingFeed = 25,
              kPulsesPerMm = 100, kMaxRate = 110, kAcceleration = 120;

EmulatedGrbl::Settings board_settings(const TransmissionSettings& transmission, ServedBoard board) {
  EmulatedGrbl::Settings settings{{kStepIdleDelay, 255}};
  if (board == ServedBoard::kEmulated) {
    settings[kHomingEnabled] = 1;
    settings[kHomingDirections] = 7;
    settings[kHomingFeed] = kHomingFeed_mm_min;
  }
  const Eigen::Vector3d pulses_per_rad = Transmission(transmission).pulses_per_rad();
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& motor = transmission.drives[i];
    const double mm_per_rad = std::abs(pulses_per_rad[i]) / kServedPulsesPerMm;
    settings[kPulsesPerMm + i] = kServedPulsesPerMm;
    settings[kMaxRate + i] = 60.0 * mm_per_rad * served_speed_deg_s(motor, board) * kDegree;
    settings[kAcceleration + i] = mm_per_rad * motor.max_acceleration_rad_s2;
  }
  return settings;
}

void require_real_time(const fs::path& firmware, const std::string& banner) {
  if (banner.rfind("Grbl 1.1", 0) == 0) return;
  throw WorkError(
      {fmt::format("{} is '{}', whose simulator takes 20 ms for each byte, too slow for real time",
                   firmware.string(), banner),
       "name the simulator of Grbl 1.1", "", Cause::kForeign});
}

}  // namespace

double served_speed_deg_s(const MotorDrive& motor, ServedBoard board) {
  const double longest =
      (board == ServedBoard::kFirmware ? kLongestFirmwareBraking_s : kLongestBraking_s) *
      motor.max_acceleration_rad_s2;
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

ShaftPipe::ShaftPipe(fs::path pipe, EmulatedGrbl::OnPosition on_position)
    : pipe_(std::move(pipe)), on_position_(std::move(on_position)) {
  if (fs::exists(pipe_) && !fs::is_fifo(pipe_))
    throw InputError(
        {"is a file, where the pipe of the motors is to be", "move it", pipe_, Cause::kExists});
  fs::remove(pipe_);
  constexpr mode_t kOwner = 0600;
  // Open for writing, too, so that it has no end when a writer goes.
  descriptor_ = mkfifo(pipe_.c_str(), kOwner) == 0 ? open(pipe_.c_str(), O_RDWR | O_CLOEXEC) : -1;
  if (descriptor_ < 0)
    throw InputError({fmt::format("cannot be made: {}", std::strerror(errno)),
                      "serve a cell whose folder can hold a pipe", pipe_, Cause::kSystem});
  lines_.emplace(descriptor_);
  constexpr double kPeriod_s = 1e-3;
  reader_.emplace(kPeriod_s, [this] { read(); });
}

ShaftPipe::~ShaftPipe() {
  reader_.reset();
  struct stat own {};
  struct stat there {};
  if (fstat(descriptor_, &own) == 0 && stat(pipe_.c_str(), &there) == 0 &&
      own.st_dev == there.st_dev && own.st_ino == there.st_ino)
    unlink(pipe_.c_str());  // nobody has taken its place
  close(descriptor_);
}

void ShaftPipe::read() {
  constexpr double kWait_s = 0.05;
  for (auto line = lines_->next(kWait_s); line; line = lines_->next(0.0)) {
    constexpr char kRecount[] = "at ";
    const bool recounts = line->rfind(kRecount, 0) == 0;
    EmulatedGrbl::Pulses counts;
    std::istringstream text(recounts ? line->substr(std::strlen(kRecount)) : *line);
    text >> counts[0] >> counts[1] >> counts[2];
    if (!text || !(text >> std::ws).eof())
      throw WorkError({fmt::format("'{}' is not where three motors are", *line),
                       "write three counts to a line", pipe_, Cause::kDevice});
    if (recounts) zero_ = here_ - counts;
    here_ = counts + zero_;
    on_position_(here_);
  }
}

ServedMotors::ServedMotors(const CellSettings& cell, const fs::path& port, LiveCell& live,
                           ServedBoard board, const fs::path& firmware)
    : live_(live), home_(Transmission(cell.transmission).pulses_from_joints(cell.arm.home)) {
  const EmulatedGrbl::Settings settings = board_settings(cell.transmission, board);
  const auto on_position = [this](const EmulatedGrbl::Pulses& shafts) { trail_.add(shafts); };
  switch (board) {
    case ServedBoard::kEmulated:
      emulated_.emplace(port, settings, on_position);
      emulated_->place_switches(Eigen::Vector3d::Zero());
      break;
    case ServedBoard::kFirmware:
      firmware_.emplace(firmware, std::vector<std::string>{}, settings, port, on_position);
      require_real_time(firmware, firmware_->banner());
      break;
    case ServedBoard::kShafts:
      shafts_.emplace(port, on_position);
  }
  live_.set_mover([this](VirtualCell& virtual_cell) { follow(virtual_cell); });
}

void ServedMotors::follow(VirtualCell& virtual_cell) {
  for (const MotorTrail::Pulses& counted : trail_.take()) {
    counted_ = counted;
    for (int i = 0; i < 3; ++i) virtual_cell.turn_motor(i, home_[i] + counted_[i] - at_marks_[i]);
  }
}

bool ServedMotors::put_at_marks() {
  if (emulated_) return false;
  return live_.now([this](VirtualCell& virtual_cell) {
    if (firmware_ && !firmware_->rests()) return false;
    at_marks_ = counted_;
    for (int i = 0; i < 3; ++i) virtual_cell.turn_motor(i, home_[i]);
    return true;
  });
}

void ServedMotors::require_well() const {
  if (emulated_) emulated_->require_well();
  if (firmware_) firmware_->require_well();
  if (shafts_) shafts_->require_well();
}

}  // namespace planar
