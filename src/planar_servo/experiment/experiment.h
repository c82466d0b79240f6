#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/experiment/experiment_plan.h"
#include "planar_servo/experiment/experiment_prediction.h"
#include "planar_servo/experiment/paper_tables.h"
#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/run/servo_run.h"

namespace planar {

struct ExperimentReport {
  std::vector<ControlCircle> circles;
  std::vector<TargetResult> ours;          ///< with the error map
  std::vector<TargetResult> paper;         ///< the paper's chain with its map
  std::vector<TargetResult> paper_no_map;  ///< the paper's chain without
  PaperTables tables;
  PositioningPrediction prediction;  ///< of ours, from its calibration alone
};

struct ExperimentRequest {
  CellSettings cell;
  Board board;
  std::uint64_t seed{0};      ///< of the training and test positions
  std::filesystem::path out;  ///< takes plan, recording and each chain's files
  ExperimentSize size{};
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
