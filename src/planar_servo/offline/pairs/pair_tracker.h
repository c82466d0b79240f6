#pragma once

#include <filesystem>
#include <vector>

#include "planar_servo/calibration/board/board.h"
#include "planar_servo/calibration/pairing.h"
#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/calibration/workplane_calibration.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/tables/frame_table.h"
#include "planar_servo/files/tables/lamp_table.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/tracker_table.h"

namespace planar {

struct PairTrackerRequest {
  CellSettings cell;
  CameraModel camera;
  std::vector<LampRow> lamps;
  std::vector<FrameRow> frames;     ///< of the recording in which the lamps were located
  std::vector<TrackerRow> tracker;  ///< readings of the tool and of the cell's monuments
  PairBy by{PairBy::kId};
  /// X_CG of boards laid on the plane, which give its height and tilt; none: the pairs do.
  std::vector<Pose> boards_on_plane;
};

struct PairTrackerReport {
  std::vector<PairRow> pairs;  ///< of all plans
  std::vector<Rejection> rejected;
  DatumRegistration datum;
  WorkplaneFit workplane;
  double largest_eccentricity_px{0.0};  ///< that was taken from a lamp's place
};

/// From what was recorded to pairs: ties the tracker to the base by the monuments, brings lamps and
/// readings together, fits workplane and tool to the places of the plans train, sweep1 and sweep3
/// (never to those kept for judging), once more
/// without the eccentricity that the lamps' discs have on that plane, and writes every place as a
/// pair of end points. Throws what the steps throw, and InputError naming lamps of images that the
/// recording lacks.
PairTrackerReport pair_tracker(const PairTrackerRequest& request);

/// Poses of the board in the recording's frames of plan plane_grid. Throws InputError naming each
/// image that cannot be read or in which the board is not found, and when there is no such frame.
std::vector<Pose> boards_on_plane(const std::filesystem::path& recording,
                                  const std::vector<FrameRow>& frames, const CameraModel& camera,
                                  const Board& board);

/// Figures of |vision - tracker| over the pairs of one plan, metres; over all of them when empty.
Summary raw_error(const std::vector<PairRow>& pairs, const std::string& plan = "");

}  // namespace planar
