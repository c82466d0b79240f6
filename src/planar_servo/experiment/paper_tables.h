#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/offline/plan/experiment_plan.h"

namespace planar {

/// The mean error after feedback that the paper prints, over its four circles.
constexpr double kPaperAfterMean_mm = 0.178;

/// Finds the pairs of a recording that lie on the circles of its plan.
class PairsOnCircles {
 public:
  /// Refers to both lists, which must outlive it.
  PairsOnCircles(const std::vector<PairRow>& pairs, const std::vector<CirclePoint>& points);

  /// Returns the pairs of a circle that checks the maps, in its order. Throws WorkError when there
  /// are none.
  std::vector<PairRow> check_circle(int radius_mm) const;

  /// Returns the places of one circle that every run has, in its order. Throws WorkError when there
  /// are none.
  std::vector<std::array<const PairRow*, kRuns>> of_all_runs(int radius_mm) const;

  /// Returns the pair of a place, or nullptr when it was left out.
  const PairRow* pair_at(const CirclePoint& point) const;

 private:
  const std::vector<CirclePoint>& points_;
  std::map<std::string, const PairRow*> by_id_;
};

/// One row of a table of the paper: what our chain found, what the paper's chain found on the same
/// recording, and what the paper printed. Values that do not exist are NaN.
struct ComparisonRow {
  std::string label;
  double ours{0.0};
  double paper_chain{0.0};
  double paper{0.0};
};

/// Says how well a map predicts the errors of vision on a circle; see MapCheck.
struct Accuracy {
  double a1{0.0};  ///< by the length of what is left of each error
  double a2{0.0};  ///< the paper's: by the mean lengths alone
};

/// One row of a table of accuracies, which are fractions.
struct AccuracyRow {
  std::string label;
  Accuracy ours, paper_chain;
  double paper{0.0};
};

/// One row of table 7: mean true errors, metres.
struct PositioningRow {
  std::string label;
  double before{0.0};  ///< where the paper's chain ends before feedback
  double ours{0.0};
  double paper_chain{0.0};
  double paper_before{0.0};
  double paper_after{0.0};
  double paper_improvement{0.0};  ///< a fraction

  /// Returns the share of the error before that is gone after.
  double improvement(double after) const { return 1.0 - after / before; }
};

/// The paper's tables 1 to 7, in their order.
struct PaperTables {
  std::vector<ComparisonRow> run_correlation;  ///< correlation of the vision error between the runs
  std::vector<AccuracyRow> idw_accuracy;       ///< on the check circles
  std::vector<ComparisonRow> map_sources;      ///< what the maps were made of, in mixed units
  std::vector<ComparisonRow> repeatability;    ///< scatter of predictions on them, metres
  std::vector<AccuracyRow> rbf_accuracy;       ///< on the check circles
  std::vector<AccuracyRow> mean_accuracy;      ///< of both methods, mean over the circles
  std::vector<PositioningRow> positioning;     ///< per control circle, and of all of them
};

/// Fills the tables that the recording decides: all but `positioning`. Both chains must have used
/// the tracker. Throws WorkError when a circle has no place with both lamps and a tracker reading.
PaperTables map_tables(const CalibratedChain& ours, const CalibratedChain& paper,
                       const ExperimentPlan& plan);

/// Returns the table of the closed loop with a row for each control circle, and one for all.
std::vector<PositioningRow> positioning_table(const std::vector<ControlCircle>& circles,
                                              const std::vector<TargetResult>& ours,
                                              const std::vector<TargetResult>& paper);

}  // namespace planar
