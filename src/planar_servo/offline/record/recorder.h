#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/tables/plan_table.h"
#include "planar_servo/machine/cell_devices.h"

namespace planar {

struct RecordRequest {
  CellSettings cell;
  std::vector<PlanRow> plan;
  std::filesystem::path recording;  ///< made when absent, gone on with when it holds a part
  std::function<bool()> stop{};     ///< as PlanarRobot::stop_when() has it
};

struct RecordReport {
  int recorded{0};  ///< plan rows recorded by this run
  int present{0};   ///< plan rows that the recording held before
  int frames{0};
  int full_frames{0};
  std::vector<std::string> without_lamps;  ///< ids where no pair of lamps was seen
};

/// Drives the cell through the plan: moves, settles, grabs frames, takes a tracker reading; for
/// board views asks for the board. Regions are placed from the COMMANDED pose by a coarse view
/// learned from the first full frames; where the lamps are not in the region, a full frame is
/// taken again. Throws InputError naming every position out of reach, workspace or joint limits
/// before anything moves; WorkError when the camera fails or somebody stops the arm: it rests, what
/// is recorded stays.
RecordReport record(const RecordRequest& request, CellDevices& devices);

}  // namespace planar
