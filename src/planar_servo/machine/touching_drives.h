#pragma once

#include <memory>
#include <string>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/virtual_cell/virtual_cell.h"

namespace planar {

/// The drives of a virtual cell among obstacles: where the arm as built touches one, all motors
/// stop with lost steps and say so, as they would be felt to.
class TouchingDrives final : public DriveGroup {
 public:
  TouchingDrives(const CellSettings& cell, std::shared_ptr<VirtualCell> world);

  void energize() override;
  void set_limits(const std::array<DriveLimits, 3>& limits) override { drives_.set_limits(limits); }
  void set_targets(const std::array<std::int32_t, 3>& targets_pulses) override {
    drives_.set_targets(targets_pulses);
  }
  void halt() override { drives_.halt(); }
  std::array<DriveStatus, 3> status() override;
  void start_homing(int joint, HomeDirection direction) override {
    drives_.start_homing(joint, direction);
  }
  void set_position(int joint, std::int32_t position_pulses) override {
    drives_.set_position(joint, position_pulses);
  }
  void reconnect() override { drives_.reconnect(); }

 private:
  std::shared_ptr<VirtualCell> world_;
  DriveGroup& drives_;
  ArmBody body_;
  std::vector<Barrier> barriers_;
  std::string touched_;  ///< what, in words; empty where nothing is
};

}  // namespace planar
