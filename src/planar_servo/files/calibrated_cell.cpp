#include "planar_servo/files/calibrated_cell.h"

#include <filesystem>

#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/map_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

std::vector<StaleFile> missing_files(const CellSettings& cell, bool with_error_map) {
  std::vector<StaleFile> missing;
  const auto look_for = [&](const fs::path& file, const char* program) {
    try {
      require_made(file, program);
    } catch (const InputError& e) {
      missing.push_back({e.refusal(), file});
    }
  };
  for (const MadeFile& file : calibration_files(cell, with_error_map))
    look_for(file.path, program_for(file.role));
  if (cell.arm_found) look_for(*cell.arm_found, "planar-fit-error-map --arm-out");
  return missing;
}

std::optional<VisionCalibration> vision_so_far(const CellSettings& cell, bool with_error_map) {
  for (const MadeFile& file : calibration_files(cell, false))
    if (!fs::exists(file.path)) return std::nullopt;
  return read_vision(cell, with_error_map && fs::exists(cell.error_map));
}

}  // namespace

CalibratedCell read_calibrated_cell(const CellSettings& settings, bool with_error_map) {
  CalibratedCell cell{settings,
                      vision_so_far(settings, with_error_map),
                      joint_planner(settings),
                      std::nullopt,
                      missing_files(settings, with_error_map),
                      {},
                      {}};
  if (settings.arm_found && fs::exists(*settings.arm_found))
    cell.planner.plan_for(read_found_arm(*settings.arm_found));
  try {
    cell.stale = stale_files(settings, with_error_map);
    if (settings.health && fs::exists(*settings.health))
      cell.health = read_health(*settings.health);
  } catch (const InputError& e) {
    cell.faults = e.refusals();
  }
  return cell;
}

void require_faultless(const CalibratedCell& cell) {
  if (!cell.faults.empty()) throw InputError(cell.faults, 0);
}

void require_calibrated(const CalibratedCell& cell) {
  require_belonging(cell.missing);
  require_faultless(cell);
}

void require_arm(const CalibratedCell& cell) {
  for (const StaleFile& file : cell.missing)
    if (file.path == cell.settings.arm_found) throw InputError(file);
}

void require_checkable(const CalibratedCell& cell) {
  require_calibrated(cell);
  require_belonging(cell.stale);
  if (cell.health) return;
  throw InputError({"names no health file that exists, so there is nothing to compare with",
                    "make one with planar-pair-tracker --health-out and name it under `health`",
                    cell.settings.file, Cause::kMissing});
}

CalibratedCell read_checkable_cell(const CellSettings& settings) {
  CalibratedCell cell = read_calibrated_cell(settings, fs::exists(settings.error_map));
  require_checkable(cell);
  return cell;
}

std::optional<std::string> accept_map(const CalibratedCell& cell, bool accepted) {
  return accept_objection(
      cell.vision.value().map_objection,
      "record more places and fit again, leave the map out (--no-error-map), or, if you know "
      "better, continue with --accept-map",
      cell.settings.error_map, accepted);
}

}  // namespace planar
