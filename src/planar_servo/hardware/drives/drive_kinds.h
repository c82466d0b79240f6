#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/cell/device_kinds.h"
#include "planar_servo/hardware/drives/grbl_protocol.h"
#include "planar_servo/hardware/drives/tic_bus.h"
#include "planar_servo/hardware/drives/tic_drives.h"

namespace planar {

/// Lists the key `home` of an item of `drives`: where a motor's position is counted from.
void list_home(Fields& drive, CellSettings& cell, std::size_t joint);

/// Returns that key, with comments, for a motor in a new cell file that is moved to a mark by hand.
std::string new_home(double mark_deg);

/// Examines the board's port, the permission to use it, its firmware, settings and state. The board
/// is reset for it, by which it forgets its position; nothing moves.
std::vector<Finding> examine_grbl(const GrblSettings& settings);

/// A Grbl or grblHAL board on a serial port: `kind: grbl` in a cell file.
class GrblKind final : public DriveKind {
 public:
  std::string name() const override { return "grbl"; }
  std::string new_keys(std::size_t joint, double mark_deg) const override;
  /// The three joints are axes of one board.
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override;
  std::shared_ptr<DriveGroup> open(const CellSettings& cell) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// Returns the settings of a cell whose drives are of this kind.
GrblSettings grbl_settings(const CellSettings& cell);

/// What reading alone shows of a Tic; nothing is switched on, moved or set.
struct TicInspection {
  std::optional<Refusal> refusal;  ///< why it cannot be used; what could be read is filled in
  TicListing listing;
  double supply_v{0.0};
  bool position_certain{false};
  /// Its errors, without those that switching on clears.
  std::vector<std::string> faults;
};

TicInspection inspect_tic(TicBus& bus, const std::string& serial);

/// Pololu Tics on USB: `kind: tic` in a cell file.
class TicKind final : public DriveKind {
 public:
  std::string name() const override { return "tic"; }
  bool moves_straight() const override { return false; }
  std::string new_keys(std::size_t joint, double mark_deg) const override;
  /// Serial numbers tell the drives apart, whatever socket they are plugged into.
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override;
  std::shared_ptr<DriveGroup> open(const CellSettings& cell) const override;
  /// Examines presence, permission, firmware, settings, supply and errors of every Tic, and whether
  /// the cell's speeds are within what a Tic can do. Nothing is switched on or moved.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// Returns the settings of a drive of this kind.
const TicSettings& tic_settings(const DriveSettings& drive);

}  // namespace planar
