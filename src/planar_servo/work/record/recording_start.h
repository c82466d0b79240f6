#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/work/record/recorder.h"

namespace planar {

/// Returns the joint angles (radians) of every row of a plan; board views stand at home. Positions
/// are reached with the cell's elbow, on the branch within the joint limits that lies nearest to
/// the row before. Throws InputError naming every position that the arm cannot or must not take.
std::vector<Joints> joints_of_plan(const CellSettings& cell, const std::vector<PlanRow>& plan);

/// Throws InputError when rows of the plan ask for readings that nobody takes, that the cell's
/// monuments cannot tie to the base, or that have the id of a monument.
void require_tracker(const RecordRequest& request);

/// The present content of a recording; nothing when it is new.
struct BegunRecording {
  std::set<std::string> ids;
  std::vector<TrackerRow> readings;  ///< of monuments and of places with frames
  std::set<std::string> dropped;     ///< the place of others
  /// The first monuments are there; one that was broken off among them reads them again.
  bool has_monuments{false};
  /// Readings of the cell's monuments before the first reading of a place.
  std::vector<MonumentSeen> first_monuments;
  /// Those that follow the last reading of a place; none when no place was read.
  std::optional<std::vector<MonumentSeen>> last_monuments;
  std::optional<double> last_frame_s;  ///< when its last frame was taken, by the clock of then
  bool ends_with_board{false};         ///< its last frame shows the board

  bool has(const PlanRow& row) const { return ids.count(row.id) != 0; }
};

/// Returns what a recording holds. `joints` are those of the plan. Throws InputError when it was
/// begun with another plan or another cell: a row of the plan was recorded for something else or
/// elsewhere, its pulses are not those of this cell's drives, its images are not of this cell's
/// sensor, or more monuments of the cell were not read than may be skipped. Throws InputError, too,
/// when the readings of several places lack their frames.
BegunRecording begun_recording(const RecordRequest& request, const std::vector<Joints>& joints);

/// Throws InputError when rows that are yet to be recorded ask for views of a board that a person
/// is to show, and the request does not say which.
void require_board(const RecordRequest& request, const BegunRecording& begun);

}  // namespace planar
