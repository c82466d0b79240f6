#include "planar_servo/experiment/experiment.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <functional>

#include "planar_servo/core/error.h"
#include "planar_servo/experiment/experiment_plan.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/offline/record/recorder.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

std::vector<TargetResult> close_loop(const CalibratedChain& chain, bool with_map,
                                     const std::vector<TargetRow>& targets, const fs::path& out,
                                     CellDevices& devices) {
  ServoRequest request;
  request.cell = chain.cell;
  request.center = chain.settings.center;
  request.use_error_map = with_map;
  request.out = out / chain.settings.name / (with_map ? "run" : "run_without_map");
  spdlog::info(fmt::format("closing the loop over {} targets: {}, {}", targets.size(),
                           chain.settings.name,
                           with_map ? "with its error map" : "without an error map"));
  ServoRun run(request, devices);
  return run_servo(run, targets);
}

}  // namespace

ExperimentReport run_experiment(const ExperimentRequest& request, CellDevices& devices) {
  if (!devices.true_tip())
    throw InputError(
        request.cell.file.string() +
        ": is no virtual cell; this experiment needs the truth of one to judge itself");
  if (fs::exists(request.out / "recording"))
    throw InputError(request.out.string() + ": holds an experiment already; name another folder");
  make_folder(request.out);
  const ExperimentPlan plan = experiment_plan(request.cell, request.seed, request.size);
  write_file(request.out / "plan.csv", plan_text(plan.rows));
  spdlog::info(fmt::format("recording {} positions and board views", plan.rows.size()));
  const RecordReport recorded =
      record({request.cell, plan.rows, request.out / "recording"}, devices);
  spdlog::info(fmt::format("{} frames, {} of them full", recorded.frames, recorded.full_frames));
  const RecordedCell recording = read_recorded_cell(request.out / "recording", request.board);
  const CalibratedChain ours =
      calibrate_chain(our_chain(request.cell), request.cell, recording, request.out);
  const CalibratedChain paper =
      calibrate_chain(paper_chain(request.cell), request.cell, recording, request.out);
  const std::vector<TargetRow> targets = control_targets(request.size);
  ExperimentReport report;
  report.circles = control_circles(request.size);
  report.ours = close_loop(ours, true, targets, request.out, devices);
  report.paper = close_loop(paper, true, targets, request.out, devices);
  report.paper_no_map = close_loop(paper, false, targets, request.out, devices);
  report.tables = map_tables(ours, paper, plan.circle_points);
  report.tables.positioning = positioning_table(report.circles, report.ours, report.paper);
  report.prediction = predict_positioning(prediction_inputs(ours), targets);
  return report;
}

PositioningPrediction predict_experiment(const ExperimentRequest& request) {
  const fs::path recording = request.out / "recording";
  if (!fs::exists(recording))
    throw InputError(recording.string() +
                     ": does not exist; --predict needs a recording there, of an experiment or of "
                     "planar-record");
  ChainSettings settings = our_chain(request.cell);
  settings.name = "prediction";
  const CalibratedChain chain = calibrate_chain(
      settings, request.cell, read_recorded_cell(recording, request.board), request.out);
  return predict_positioning(prediction_inputs(chain), control_targets(request.size));
}

}  // namespace planar
