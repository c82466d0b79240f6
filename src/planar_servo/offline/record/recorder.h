#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/plan_table.h"
#include "planar_servo/machine/cell_devices.h"

namespace planar {

/// Each monument is read so many times before the places, and again after them.
constexpr int kMonumentReadings = 5;

/// Says what is to be recorded, and where.
struct RecordRequest {
  CellSettings cell;
  std::vector<PlanRow> plan;
  std::filesystem::path recording;  ///< made when absent; continued when it holds a part
  std::function<bool()> stop{};     ///< asked during every move; see PlanarRobot::stop_when()
};

/// Says what a recording holds.
struct RecordReport {
  int recorded{0};  ///< plan rows recorded by this run
  int present{0};   ///< plan rows that the recording held before
  int frames{0};
  int full_frames{0};
  std::vector<std::string> without_lamps;  ///< ids where no pair of lamps was seen
};

/// Drives the cell through the plan. At each position it moves, settles, grabs frames and takes a
/// tracker reading; for board views it asks for the board. Regions are placed from the commanded
/// pose by a coarse view learned from the first full frames. Where the lamps are not in the region,
/// a full frame is taken instead. The monuments are read before all and, when the arm has moved,
/// once more at the end.
///
/// Throws InputError naming every position out of reach, workspace or joint limits, and what a
/// recording that was begun has of another plan or cell, before anything moves. Throws WorkError
/// when the camera fails or somebody stops the arm: the arm then rests, and what is recorded stays.
RecordReport record(const RecordRequest& request, CellDevices& devices);

}  // namespace planar
