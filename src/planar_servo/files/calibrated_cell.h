#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/loop/health/health_record.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// A cell as its files tell it: what a person wrote of it, and what calibration has found so far.
/// The planner follows from the settings: whoever changes these reads the files again.
struct CalibratedCell {
  CellSettings settings;
  std::optional<VisionCalibration> vision;  ///< once camera, workplane and tool are known
  JointPlanner planner;                     ///< of the arm that was found, as soon as it is
  std::optional<HealthRecord> health;       ///< none where the cell names no file that exists
  std::vector<StaleFile> missing;  ///< what motion by vision needs, with the program that makes it
  std::vector<StaleFile> stale;    ///< what does not belong together
  /// Faults of the health file, and of what files say they were made from: a person may still move
  /// the arm by hand.
  std::vector<Refusal> faults;
};

/// Reads a cell's files, each once. Throws as read_vision() and read_found_arm() do, but for files
/// that are missing.
CalibratedCell read_calibrated_cell(const CellSettings& settings, bool with_error_map = true);

/// Returns whether what vision sees in this cell is compensated.
inline bool uses_error_map(const CalibratedCell& cell) {
  return cell.vision && cell.vision->error_map;
}

/// Throws InputError with the faults, if there are any.
void require_faultless(const CalibratedCell& cell);

/// Throws InputError naming every file that is missing, or else the faults.
void require_calibrated(const CalibratedCell& cell);

/// Throws the same where only the arm that the cell names was not found yet.
void require_arm(const CalibratedCell& cell);

/// Throws InputError unless a check alone can tell something: the files are there, belong together
/// and one of them is a health file.
void require_checkable(const CalibratedCell& cell);

/// Reads a cell for a check alone, which does without an error map. Throws as require_checkable()
/// does.
CalibratedCell read_checkable_cell(const CellSettings& settings);

/// Returns and logs the objection of the error map's fit to moving by it. Throws InputError with it
/// unless it is accepted.
std::optional<std::string> accept_map(const CalibratedCell& cell, bool accepted);

}  // namespace planar
