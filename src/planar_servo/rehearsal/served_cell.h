#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/rehearsal/served_tracker.h"

namespace planar {

/// Where a served cell's devices are found.
struct ServedPlaces {
  std::string address, camera_id;
  std::filesystem::path grbl_port;
  TrackerOutlet tracker;
  bool decimal_comma{false};  ///< in the tracker's lines
  bool firmware{false};       ///< whether the board is real firmware, which has no home switches
};

/// Returns the text of a cell file that states where the devices are found, and otherwise what the
/// virtual cell's file states. It names no truth. Motors are as fast as their Grbl board (see
/// served_speed_deg_s()).
std::string live_cell_text(const CellSettings& cell, const ServedPlaces& places);

/// What is to be served, and where.
struct ServeRequest {
  CellSettings cell;                 ///< a virtual one
  std::string address{"127.0.0.1"};  ///< of this machine, for camera and tracker
  /// Where to put the link to the board's serial port; its folder serves one cell at a time.
  std::filesystem::path grbl_port;
  /// A simulator of Grbl 1.1 that is the board, which has no home switches then; without it the
  /// board is emulated.
  std::optional<std::filesystem::path> grbl_firmware;
  /// The file to which the tracker appends its lines; without it they come from a port.
  std::optional<std::filesystem::path> tracker_file;
  ReflectorDialect tracker;
  std::optional<std::filesystem::path> truth_log;  ///< for the scorer; see TruthLog
};

/// A virtual cell as real devices of this machine: its camera on GigE Vision, its drives as a Grbl
/// board, its tracker as lines on a port or in a file. The devices serve as long as this object
/// lives.
class ServedCell {
 public:
  /// Clients find the devices once this returns. Throws InputError when the cell is not virtual or
  /// a file or option cannot be used, and WorkError when an address or port cannot.
  explicit ServedCell(const ServeRequest& request);
  ~ServedCell();
  ServedCell(const ServedCell&) = delete;
  ServedCell& operator=(const ServedCell&) = delete;

  /// Says what is served and where, a line for each device.
  std::string description() const;
  /// Returns the text of a cell file for these devices; see live_cell_text().
  std::string live_text() const;

  /// Does what obey_command() says and returns its answer.
  std::string obey(const std::string& line);
  /// Throws what has ended one of the devices, such as a disk that is full.
  void require_well() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
