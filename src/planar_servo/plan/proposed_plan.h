#pragma once

#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/tables/pair_table.h"
#include "planar_servo/tables/recording_tables.h"

namespace planar {

/// Without a reading the lays must be turned against each other, and the tool must.
constexpr int kFewestLays = 2;

/// Says what to plan.
struct PlanRequest {
  int readings{0};    ///< of the tracker; with none of them lays and poses tell all
  int unattended{0};  ///< places that only the camera watches, with the tool turned anyhow
  int lays{1};        ///< of the board on the plane, where the plan begins a calibration
};

/// A plan of the next tracker readings, and the accuracy to expect of the end point after them,
/// mean length over the workspace, metres.
struct ProposedPlan {
  std::vector<PlanRow> rows;
  int readings{0};
  double before{0.0};  ///< by what was read so far
  double after{0.0};
  int enough{0};  ///< this many of the readings reach nearly that accuracy

  /// Returns whether further readings gain so little that they are not worth their time.
  bool worth_reading() const;
};

/// Proposes places for the readings where the field at the lamps is least certain, as far as the
/// arm reaches them. Without pairs the plan begins a calibration: the sweeps, which take their
/// share of the readings, and last the views of the board, for which the tracker is not needed.
/// With pairs it continues from them. Unattended places follow the readings. The places come in an
/// order that is random in space, the same every time. Throws InputError for a plan without
/// readings that has less than kFewestLays or kFewestPoses places, as with_readings(),
/// pose_samples() and estimate_jointly() do, and for a cell in whose workspace no place can be
/// reached.
ProposedPlan propose_plan(const CellSettings& cell, const PlanRequest& request,
                          const std::vector<PairRow>& pairs = {});

/// Returns what to expect of a plan, in words.
std::string proposal_text(const ProposedPlan& plan);

}  // namespace planar
