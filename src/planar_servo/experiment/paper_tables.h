#pragma once

#include <string>
#include <vector>

#include "planar_servo/experiment/experiment_plan.h"
#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/run/servo_figures.h"

namespace planar {

/// One row of a table of the paper: what our chain found, what the paper's chain found on the same
/// recording, and what the paper printed. Values that do not exist are NaN.
struct ComparisonRow {
  std::string label;
  double ours{0.0};
  double paper_chain{0.0};
  double paper{0.0};
};

/// The paper's tables 1 to 7, in their order.
struct PaperTables {
  std::vector<ComparisonRow> run_correlation;  ///< correlation of the vision error between the runs
  std::vector<ComparisonRow> idw_accuracy;     ///< accuracy on the check circles, a fraction
  std::vector<ComparisonRow> map_sources;      ///< what the maps were made of, in mixed units
  std::vector<ComparisonRow> repeatability;    ///< scatter of predictions over the runs, metres
  std::vector<ComparisonRow> rbf_accuracy;     ///< accuracy on the check circles, a fraction
  std::vector<ComparisonRow> mean_accuracy;    ///< accuracy of both methods, mean over the circles
  std::vector<ComparisonRow> positioning;      ///< mean true error per control circle, metres
};

/// Fills the tables that the recording decides: all but `positioning`. Both chains must have used
/// the tracker. Throws WorkError when a circle has no place with both lamps and a tracker reading.
PaperTables map_tables(const CalibratedChain& ours, const CalibratedChain& paper,
                       const ExperimentPlan& plan);

/// Returns the table of the closed loop with a row for each control circle.
std::vector<ComparisonRow> positioning_table(const std::vector<ControlCircle>& circles,
                                             const std::vector<TargetResult>& ours,
                                             const std::vector<TargetResult>& paper);

/// Returns the results at the targets of one control circle.
std::vector<TargetResult> results_on(const ControlCircle& circle,
                                     const std::vector<TargetResult>& results);

}  // namespace planar
