#pragma once

#include "planar_servo/base/devices/drive_group.h"

namespace planar {

/// Passes everything on to other drives, for those who change or watch some of it.
class ForwardingDrives : public DriveGroup {
 public:
  /// The drives must outlive this.
  explicit ForwardingDrives(DriveGroup& drives) : drives_(drives) {}

  void energize() override { drives_.energize(); }
  void set_limits(const std::array<DriveLimits, 3>& limits) override { drives_.set_limits(limits); }
  void set_targets(const std::array<std::int32_t, 3>& targets_pulses) override {
    drives_.set_targets(targets_pulses);
  }
  void brake_towards(const std::array<std::int32_t, 3>& targets_pulses) override {
    drives_.brake_towards(targets_pulses);
  }
  void halt() override { drives_.halt(); }
  std::array<DriveStatus, 3> status() override { return drives_.status(); }
  void start_homing(int joint, HomeDirection direction) override {
    drives_.start_homing(joint, direction);
  }
  void set_position(int joint, std::int32_t position_pulses) override {
    drives_.set_position(joint, position_pulses);
  }
  void forget_positions() override { drives_.forget_positions(); }
  std::optional<std::string> stream_refusal() const override { return drives_.stream_refusal(); }
  void reconnect() override { drives_.reconnect(); }

 private:
  DriveGroup& drives_;
};

}  // namespace planar
