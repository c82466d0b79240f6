#pragma once

#include "planar_servo/devices/drive_group.h"

namespace planar {

/// Commands three drives that share no bus one after the other.
class SeparateDrives final : public DriveGroup {
 public:
  /// The drives must outlive the group.
  explicit SeparateDrives(const std::array<PulseDrive*, 3>& drives) : drives_(drives) {}

  void energize() override;
  void set_limits(const std::array<DriveLimits, 3>& limits) override;
  void set_targets(const std::array<std::int32_t, 3>& targets_pulses) override;
  void halt() override;
  std::array<DriveStatus, 3> status() override;
  void start_homing(int joint, HomeDirection direction) override;
  void set_position(int joint, std::int32_t position_pulses) override;
  void reconnect() override {}  ///< such drives are never out of touch

 private:
  std::array<PulseDrive*, 3> drives_;
};

}  // namespace planar
