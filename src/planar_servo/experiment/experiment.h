#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/experiment/experiment_prediction.h"
#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/run/servo_run.h"

namespace planar {

/// One row of a table of the paper: what we found, what the paper's chain found on the same
/// recording, and what the paper printed. Values not available are NaN.
struct ComparisonRow {
  std::string label;
  double ours{0.0};
  double paper_chain{0.0};
  double paper{0.0};
};

struct ExperimentReport {
  std::vector<TargetResult> ours;          ///< with the error map
  std::vector<TargetResult> paper;         ///< the paper's chain with its map
  std::vector<TargetResult> paper_no_map;  ///< the paper's chain without
  std::vector<ComparisonRow> table1;       ///< correlation of the vision error between runs
  std::vector<ComparisonRow> table2;       ///< accuracy of IDW on three circles, fraction
  std::vector<ComparisonRow> table3;  ///< what the maps were made of and are worth; mixed units
  std::vector<ComparisonRow> table4;  ///< repeatability of predictions over three runs, metres
  std::vector<ComparisonRow> table5;  ///< accuracy of the RBF on three circles, fraction
  std::vector<ComparisonRow> table6;  ///< means of tables 2 and 5
  std::vector<ComparisonRow> table7;  ///< mean true error per control circle, metres
  PositioningPrediction prediction;   ///< of ours, from its calibration alone
};

struct ExperimentRequest {
  CellSettings cell;
  Board board;
  std::uint64_t seed{0};      ///< of the training and test positions
  std::filesystem::path out;  ///< takes plan, recording and each chain's files
};

/// The paper's experiment: records a plan, calibrates both chains from what was recorded, and
/// closes the loop over the control targets with each. Throws what its parts throw, and InputError
/// when `out` holds a run already.
ExperimentReport run_experiment(const ExperimentRequest& request, CellDevices& devices);

/// What the recording in `out` lets expect of positioning at the control targets; opens neither a
/// device nor a truth. The calibration stands in `out/prediction` then. Throws InputError when
/// there is no recording.
PositioningPrediction predict_experiment(const ExperimentRequest& request);

}  // namespace planar
