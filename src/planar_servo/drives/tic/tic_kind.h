#pragma once

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/drives/tic/tic_drives.h"

namespace planar {

/// Pololu Tics on USB: `kind: tic` in a cell file.
class TicKind final : public DriveKind {
 public:
  std::string name() const override { return "tic"; }
  std::string new_keys(std::size_t joint, double mark_deg) const override;
  /// Serial numbers tell the drives apart, whatever socket they are plugged into.
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override;
  std::shared_ptr<DriveGroup> open(const CellSettings& cell,
                                   const std::shared_ptr<VirtualCell>& world) const override;
  /// Presence, permission, firmware, settings, supply and errors of every Tic, and whether the
  /// speeds of the cell are within what a Tic can do.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// The settings of a drive of this kind.
const TicSettings& tic_settings(const DriveSettings& drive);

}  // namespace planar
