#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/drives/tic_bus.h"
#include "planar_servo/drives/tic_drives.h"

namespace planar {

/// Holds what can be told of a Tic by reading only; nothing is switched on, moved or set.
struct TicInspection {
  std::optional<Refusal> refusal;  ///< why it cannot be used; what could be read is filled in
  TicListing listing;
  double supply_v{0.0};
  bool position_certain{false};
  /// Its errors without those that switching on clears.
  std::vector<std::string> faults;
};

TicInspection inspect_tic(TicBus& bus, const std::string& serial);

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
