#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/served_cell/tracker/served_tracker.h"

namespace planar {

/// Where a served cell's devices are found.
struct ServedPlaces {
  std::string address, camera_id;
  std::filesystem::path grbl_port;
  TrackerOutlet tracker;
  bool decimal_comma{false};  ///< in the tracker's lines
  bool firmware{false};       ///< real one is the board, which has no home switches
};

/// Returns the text of a cell file that states of the devices where they are found and of the rest
/// what the virtual cell's file states. It names no truth. Motors are as fast as their Grbl board
/// (see served_speed_deg_s()).
std::string live_cell_text(const CellSettings& cell, const ServedPlaces& places);

}  // namespace planar
