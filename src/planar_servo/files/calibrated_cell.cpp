#include "planar_servo/files/calibrated_cell.h"

#include <filesystem>

#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/map_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

std::optional<VisionCalibration> vision_so_far(const CellSettings& cell, bool with_error_map) {
  if (!missing_files(calibration_files(cell, false)).empty()) return std::nullopt;
  return read_vision(cell, with_error_map && fs::exists(cell.error_map));
}

}  // namespace

CalibratedCell read_calibrated_cell(const CellSettings& settings, bool with_error_map) {
  std::vector<MadeFile> needed = calibration_files(settings, with_error_map);
  if (settings.arm_found) needed.push_back({Role::kArmFound, *settings.arm_found});
  CalibratedCell cell{settings,
                      vision_so_far(settings, with_error_map),
                      joint_planner(settings),
                      std::nullopt,
                      missing_files(needed),
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
