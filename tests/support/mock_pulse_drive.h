#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/drive_group.h"

namespace planar::test {

/// A drive that remembers what it was told and turns at constant speed on the given clock.
class MockPulseDrive final : public PulseDrive {
 public:
  explicit MockPulseDrive(const Clock& clock) : clock_(clock) {}

  std::vector<std::int32_t> targets;  ///< every target ever set
  int halts{0};
  double max_speed_pulses_s{0.0};
  double max_acceleration_pulses_s2{0.0};
  bool refuses_targets{false};
  bool stalls{false};  ///< moves for ever, without arriving
  bool knows_position{true};
  std::string fault;             ///< reported at once; empty for none
  std::string fault_on_the_way;  ///< reported while the drive moves; empty for none
  bool by_hand{false};           ///< its faults are stops by hand

  void energize() override { energized_ = true; }
  void set_limits(const DriveLimits& limits) override {
    start_ = position();
    started_s_ = clock_.now_s();
    max_speed_pulses_s = limits.speed_pulses_s;
    max_acceleration_pulses_s2 = limits.acceleration_pulses_s2;
  }
  void set_target(std::int32_t target_pulses) override {
    if (refuses_targets) throw WorkError("the mock drive refuses its target", Cause::kDevice);
    start_ = position();
    started_s_ = clock_.now_s();
    target_ = target_pulses;
    targets.push_back(target_pulses);
  }
  void halt() override {
    ++halts;
    target_ = start_ = position();
    stalls = homing_ = false;
  }
  void forget_position() override {
    halt();
    knows_position = false;
  }
  DriveStatus status() override {
    const bool moving = stalls || position() != target_;
    if (homing_ && !moving) {
      homing_ = false;
      set_position(0);
    }
    DriveStatus status{position(), target_, energized_, moving, knows_position, homing_};
    if (!fault.empty()) status.faults.push_back(fault);
    if (moving && !fault_on_the_way.empty()) status.faults.push_back(fault_on_the_way);
    status.stopped_by_hand = by_hand && !status.faults.empty();
    return status;
  }

  void start_homing(HomeDirection direction) override {
    set_target(direction == HomeDirection::kForward ? kSwitch_pulses : -kSwitch_pulses);
    knows_position = false;
    homing_ = true;
  }
  void set_position(std::int32_t position_pulses) override {
    target_ = start_ = position_pulses;
    knows_position = true;
  }

  /// The distance of the home switch in either direction.
  static constexpr std::int32_t kSwitch_pulses = 50000;

 private:
  std::int32_t position() const {
    const double travel = max_speed_pulses_s * (clock_.now_s() - started_s_);
    const double distance = static_cast<double>(target_) - start_;
    if (travel >= std::abs(distance)) return target_;
    return start_ + static_cast<std::int32_t>(std::lround(std::copysign(travel, distance)));
  }

  const Clock& clock_;
  bool energized_{false};
  bool homing_{false};
  std::int32_t start_{0};
  std::int32_t target_{0};
  double started_s_{0.0};
};

}  // namespace planar::test
