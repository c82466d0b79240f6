#pragma once

#include <cstddef>
#include <vector>

#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/learn/field/joint_estimate.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Says where the next tracker readings tell most, and the end point's uncertainty with them.
struct NextPlaces {
  std::vector<std::size_t> chosen;  ///< among the candidates, the most telling first
  /// Standard deviation per axis of the compensated end point, mean over the candidates, metres:
  /// before any of the chosen is read, and after each of them; `first` is read by then.
  std::vector<double> sigmas;
};

/// Chooses up to `count` of the candidates, one after the other, each where the end point is least
/// certain by then. The poses `first` are read before them in any case. A candidate is a pose with
/// the deviations that its reading and its lamps would have. Linear Gaussian theory: what is read
/// does not matter, only where.
NextPlaces choose_next_places(const JointEstimate& estimate,
                              const std::vector<PoseSample>& candidates, std::size_t count,
                              const std::vector<PoseSample>& first = {});

/// Without a reading the lays must be turned against each other, and the tool must.
constexpr int kFewestLays = 2;

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
  int left_out{0};     ///< places asked for that the rows lack
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

ReportList proposal_list(const ProposedPlan& plan);

}  // namespace planar
