#pragma once

#include <optional>
#include <vector>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/calibration/pairing.h"
#include "planar_servo/calibration/readings/tracker_clock.h"
#include "planar_servo/calibration/tracker_registration.h"
#include "planar_servo/calibration/workplane_calibration.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/offline/pairs/laid_boards.h"
#include "planar_servo/offline/pairs/recording_check.h"

namespace planar {

/// Holds what lamps and tracker recorded of a cell.
struct PairTrackerRequest {
  CellSettings cell;
  CameraModel camera;
  std::vector<LampRow> lamps;
  std::vector<FrameRow> frames;     ///< frames of the recording in which the lamps were located
  std::vector<TrackerRow> tracker;  ///< readings of the tool and of the cell's monuments
  PairBy by{PairBy::kId};
  /// Boards laid on the plane, which give its height and tilt. Without boards the pairs give them.
  std::vector<LaidBoard> boards_on_plane;
  double dots_height{0.0};  ///< of the boards' dots above the lamps' plane, metres
  /// A step or a trend in the vision error is doubted, however large it is.
  bool accept_step{false};
};

/// Holds the pairs and what was fitted to make them.
struct PairTrackerReport {
  std::vector<PairRow> pairs;  ///< of all plans, the unattended poses last
  std::vector<Rejection> rejected;
  std::optional<DatumRegistration> datum;  ///< none without a tracker
  WorkplaneFit workplane;
  std::optional<TrackerClock> clock;    ///< of the tracker, where it was paired by time
  double largest_eccentricity_px{0.0};  ///< largest shift taken from a lamp's place
  std::optional<RecordedStep> step;     ///< in the vision error of the training pairs
  std::optional<RecordedTrend> trend;   ///< of that error, where there is no step
  std::vector<Refusal> doubts;          ///< what the readings leave open, and what to do
};

/// Joins the lamps' rows with what the recording knows of their frames. Views of boards are left
/// out. Throws InputError naming lamps of images that the recording lacks.
std::vector<LampSight> lamp_sights(const std::vector<LampRow>& lamps,
                                   const std::vector<FrameRow>& frames);

/// Makes pairs of what was recorded. It ties the tracker to the base by the monuments, brings lamps
/// and readings together, and fits workplane and tool to the places of the plans train, sweep1 and
/// sweep3, never to those kept for judging. It then takes off the eccentricity that the lamps'
/// discs have on that plane and fits again, and writes every place as a pair of end points, those
/// of plan pose without the tracker's.
///
/// Without a reading of the tool all pairs are unattended, whatever the plans. The plane is that of
/// the boards, without which it throws InputError; place and turn in it come from where the arm was
/// sent (fit_workplane_to_arm) and are as wrong as the cell file is about the arm, until field and
/// arm are learned. The reflector on the tool stays unknown.
///
/// Monuments read after the first reading of the tool serve to show what moved meanwhile, unless
/// they were not read before. Throws what these steps throw, InputError naming lamps of images that
/// the recording lacks, and InputError where readings contradict the cell (recording_check.h).
PairTrackerReport pair_tracker(const PairTrackerRequest& request);

/// Returns the figures of |vision - tracker| over the attended pairs of one plan, metres. With an
/// empty plan all of them count.
Summary raw_error(const std::vector<PairRow>& pairs, std::optional<Purpose> plan = std::nullopt);

}  // namespace planar
