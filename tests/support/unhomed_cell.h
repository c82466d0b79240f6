#pragma once

#include <array>

#include "planar_servo/base/devices/drive_group.h"
#include "support/manual_clock.h"
#include "support/mock_pulse_drive.h"
#include "support/silent_cell.h"

namespace planar::test {

/// A virtual cell that passes for a real one, with other drives, which may have lost their
/// positions.
class UnhomedCell : public SilentCell {
 public:
  using SilentCell::SilentCell;

  Clock& clock() override { return clock_; }
  DriveGroup& drives() override { return drives_; }

 private:
  ManualClock clock_;

 public:
  std::array<MockPulseDrive, 3> motors{MockPulseDrive(clock_), MockPulseDrive(clock_),
                                       MockPulseDrive(clock_)};

 private:
  SeparateDrives drives_{{&motors[0], &motors[1], &motors[2]}};
};

}  // namespace planar::test
