#pragma once

#include <functional>
#include <memory>

#include "planar_servo/machine/device_kinds.h"

namespace planar::test {

/// A virtual cell that tells nobody its truth, and so passes for a real one.
class SilentCell : public CellDevices {
 public:
  explicit SilentCell(const CellSettings& cell) : devices_(open_cell(cell)) {}

  Clock& clock() override { return devices_->clock(); }
  FrameSource& camera() override { return devices_->camera(); }
  DriveGroup& drives() override { return devices_->drives(); }
  Tracker& tracker() override { return devices_->tracker(); }
  BoardPresenter* board_presenter() override { return nullptr; }
  std::shared_ptr<Judge> truth() override { return nullptr; }

 protected:
  CellDevices& virtual_devices() { return *devices_; }

 private:
  std::unique_ptr<CellDevices> devices_;
};

}  // namespace planar::test
