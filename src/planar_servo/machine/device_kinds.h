#pragma once

#include <filesystem>
#include <memory>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/virtual_cell/virtual_drive.h"

namespace planar {

/// Holds the opened devices of a cell. Its user cannot tell a virtual cell from a real one, except
/// by `truth`, which only a scorer may use.
class CellDevices {
 public:
  virtual ~CellDevices() = default;
  /// The devices live as long as this object. A virtual cell has a clock of its own.
  virtual Clock& clock() = 0;
  virtual FrameSource& camera() = 0;
  virtual DriveGroup& drives() = 0;
  virtual Tracker& tracker() = 0;
  /// Returns null where only a person can show the calibration board.
  virtual BoardPresenter* board_presenter() = 0;

  /// Returns the judge that knows the true end point, or null unless the cell is virtual. It serves
  /// the scorer of `_truth` figures only.
  virtual std::shared_ptr<Judge> truth() = 0;
};

/// Checks that the cell's devices go together. Throws InputError naming every device that does not
/// go with the others, and when a virtual cell names no truth file.
void require_devices(const CellSettings& cell);

/// Opens the devices that the cell names, each by its kind. Throws what require_devices() and the
/// kinds throw, and InputError for a truth file that cannot be read.
std::unique_ptr<CellDevices> open_cell(const CellSettings& cell);

/// Returns the kinds of cameras, drives and trackers that this version can open. CONTRIBUTING.md
/// says how to add a kind; it has a line in the list behind this function.
const DeviceKinds& device_kinds();

/// Reads a cell file that may name any of device_kinds(). Throws InputError naming every fault with
/// FILE:LINE:COLUMN.
CellSettings read_cell(const std::filesystem::path& path);

/// Returns the hardware that a virtual cell with these settings is made of, unless its truth knows
/// better.
VirtualHardware virtual_hardware(const CellSettings& cell);

}  // namespace planar
