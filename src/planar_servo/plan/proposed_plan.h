#pragma once

#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/tables/pair_table.h"
#include "planar_servo/tables/recording_tables.h"

namespace planar {

/// A plan of the next tracker readings, and the accuracy to expect of the end point after them,
/// mean length over the workspace, metres.
struct ProposedPlan {
  std::vector<PlanRow> rows;
  double before{0.0};  ///< by what was read so far
  double after{0.0};
  int enough{0};  ///< this many of the readings reach nearly that accuracy

  /// Returns whether further readings gain so little that they are not worth their time.
  bool worth_reading() const;
};

/// Proposes `readings` places where the field at the lamps is least certain, as far as the arm
/// reaches them. Without pairs the plan begins a calibration: the sweeps, which take their share of
/// the readings, and last the views of the board, for which the tracker is not needed. With pairs
/// it continues from them. The places come in an order that is random in space, the same every
/// time. Throws InputError as with_readings(), pose_samples() and estimate_jointly() do, and for a
/// cell in whose workspace no place can be reached.
ProposedPlan propose_plan(const CellSettings& cell, int readings,
                          const std::vector<PairRow>& pairs);

/// Returns what to expect of a plan, in words.
std::string proposal_text(const ProposedPlan& plan);

}  // namespace planar
