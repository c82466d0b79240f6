#pragma once

#include <memory>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/core/clock.h"
#include "planar_servo/devices/board_presenter.h"
#include "planar_servo/devices/drive_group.h"
#include "planar_servo/devices/frame_source.h"
#include "planar_servo/devices/judge.h"
#include "planar_servo/devices/tracker.h"

namespace planar {

/// Holds the opened devices of a cell. Its user cannot tell a virtual cell from a real one, except
/// by `truth`, which only a scorer may use.
class CellDevices {
 public:
  virtual ~CellDevices() = default;
  /// These are the devices. They live as long as this object. A virtual cell has a clock of its
  /// own.
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

}  // namespace planar
