#pragma once

#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/cell/device_kinds.h"
#include "planar_servo/drives/grbl_protocol.h"

namespace planar {

/// The board's port, the permission to use it, its firmware, settings and state. The board is reset
/// for it, by which it forgets its position; nothing moves.
std::vector<Finding> examine_grbl(const GrblSettings& settings);

/// A Grbl or grblHAL board on a serial port: `kind: grbl` in a cell file.
class GrblKind final : public DriveKind {
 public:
  std::string name() const override { return "grbl"; }
  std::string new_keys(std::size_t joint, double mark_deg) const override;
  /// The three joints are axes of one board.
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override;
  std::shared_ptr<DriveGroup> open(const CellSettings& cell,
                                   const std::shared_ptr<VirtualCell>& world) const override;
  /// The port and the permission to use it, the firmware, its settings and its state. The board is
  /// reset for it.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// The settings of a cell whose drives are of this kind.
GrblSettings grbl_settings(const CellSettings& cell);

}  // namespace planar
