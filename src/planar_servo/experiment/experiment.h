#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "planar_servo/experiment/paper_tables.h"
#include "planar_servo/experiment/plots/plot_data.h"
#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/plan/experiment_plan.h"
#include "planar_servo/offline/plan/predicted_positioning.h"
#include "planar_servo/report/live_view.h"
#include "planar_servo/work/run/servo_run.h"

namespace planar {

struct ExperimentReport {
  std::vector<ControlCircle> circles;
  std::vector<TargetResult> ours;          ///< our chain with its error map
  std::vector<TargetResult> paper;         ///< the paper's chain with its map
  std::vector<TargetResult> paper_no_map;  ///< the paper's chain without a map
  std::vector<TargetResult> visp;          ///< ViSP's chain, which has no map
  PaperTables tables;                      ///< without a tracker only `positioning`
  std::optional<PlotData> recorded{};      ///< what the paper's figures are drawn from
  PositioningPrediction prediction;        ///< of our chain, from its calibration alone
  /// By which `ours` was turned about the base's axis, radians, where nothing had fixed the turn.
  std::optional<double> turn_taken_out{};
  /// Standard deviation per axis of the reflector's offset, metres, where a tracker judged in place
  /// of a truth: no figure shows that error.
  std::optional<double> reflector_sigma{};
};

/// Says on which cell an experiment is made, and where its files go.
struct ExperimentRequest {
  CellSettings cell;
  Board board;
  std::uint64_t seed{0};      ///< draws the training and test positions
  std::filesystem::path out;  ///< folder for plan, recording and each chain's files
  ExperimentSize size{};
  bool uses_tracker{true};  ///< in our chain; see ChainSettings
  std::optional<double> dots_height{};
  bool accept_step{false};  ///< see PairTrackerRequest; in every chain
  bool accept_map{false};   ///< see ServoRequest; in our chain
  // These are for a real cell, as in RecordRequest.
  DisplayPolicy display{DisplayPolicy::kNone};
  MayHome may_home{};
  std::function<bool()> stop{};
};

/// Runs the paper's experiment: it records a plan, calibrates the chains from what was recorded,
/// and closes the loop over the control targets with each. What an experiment with the same request
/// left in `out` is continued: recorded positions and finished targets are not visited again. A
/// cell without a truth is judged by its tracker, after a person has done what record() and
/// TrackerJudge ask for. Throws what its parts throw, and InputError when `out` holds something
/// else and, before anything moves, for a cell that nobody can judge.
ExperimentReport run_experiment(const ExperimentRequest& request, CellDevices& devices);

/// Predicts positioning at the control targets from the recording in `out`. It opens neither a
/// device nor a truth, and writes its calibration to `out/prediction`. Throws InputError when there
/// is no recording.
PositioningPrediction predict_experiment(const ExperimentRequest& request);

/// Returns how the loop is closed with a chain. It continues with the run that the experiment's
/// folder holds.
ServoRequest control_loop(const CalibratedChain& chain, bool with_map,
                          const ExperimentRequest& experiment);

/// Returns what decides the rows of a campaign: the cell file's content, the board and how much is
/// recorded and used.
nlohmann::json making_of_campaign(const ExperimentRequest& request);

/// Throws InputError when what `file` was begun with is not what it would continue with, naming
/// every key that differs.
void require_same_making(const std::filesystem::path& file, const nlohmann::json& begun,
                         const nlohmann::json& now);

/// Makes the folder of an experiment and writes down there what it is made with, or continues with
/// one that was begun with the same. Throws InputError when the folder holds another experiment or
/// a campaign.
void begin_experiment(const ExperimentRequest& request);

}  // namespace planar
