#include "planar_servo/experiment/experiment.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <functional>
#include <future>

#include "planar_servo/core/error.h"
#include "planar_servo/core/plane_geometry.h"
#include "planar_servo/experiment/begun_experiment.h"
#include "planar_servo/experiment/experiment_plan.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/offline/record/recorder.h"
#include "planar_servo/run/resumed_run.h"

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
  request.check_health = chain.settings.checks_health;
  request.keep_going = true;  // a target that fails is a result, too
  request.out = out / chain.settings.name / (with_map ? "run" : "run_without_map");
  request.resume = fs::exists(results_file(request));
  spdlog::info(fmt::format("closing the loop over {} targets: {}, {}", targets.size(),
                           chain.settings.name,
                           with_map ? "with its error map" : "without an error map"));
  ServoRun run(request, devices);
  return run_servo(run, targets);
}

ChainSettings our_settings(const ExperimentRequest& request) {
  ChainSettings settings = our_chain(request.cell);
  settings.uses_tracker = request.uses_tracker;
  settings.dots_height = request.dots_height;
  return settings;
}

struct CalibratedChains {
  CalibratedChain ours, visp, paper;
};

/// Calibrates the paper's chain at the same time as our chain and then ViSP's. These two may both
/// use vpCalibration, whose settings are global.
CalibratedChains calibrate_chains(const ExperimentRequest& request, const RecordedCell& recording) {
  const auto calibrate = [&](const ChainSettings& settings) {
    return calibrate_chain(settings, request.cell, recording, request.out);
  };
  auto paper = std::async(std::launch::async, calibrate, paper_chain(request.cell));
  CalibratedChain ours = calibrate(our_settings(request));
  CalibratedChain visp = calibrate(visp_chain(request.cell));
  return {std::move(ours), std::move(visp), paper.get()};
}

/// Turns all true places about the base's axis by the angle that brings them nearest to their
/// targets, and returns it, radians.
double take_out_turn(std::vector<TargetResult>& results) {
  Eigen::Vector2d sum(0.0, 0.0);
  for (const TargetResult& result : results) {
    if (!result.after_truth) continue;
    const Eigen::Vector2d p = result.p_d + *result.after_truth;
    sum += Eigen::Vector2d(p.dot(result.p_d), p.x() * result.p_d.y() - p.y() * result.p_d.x());
  }
  const double turn = std::atan2(sum.y(), sum.x());
  for (TargetResult& result : results) {
    if (!result.after_truth) continue;
    const auto moved_by = [&](const Eigen::Vector2d& error) -> Eigen::Vector2d {
      const Eigen::Vector2d p = result.p_d + error;
      return rotation2d(turn) * p - p;
    };
    const Eigen::Vector2d shift = moved_by(*result.after_truth);
    if (result.before_truth) *result.before_truth += moved_by(*result.before_truth);
    *result.after_truth += shift;
    for (auto* error : {&result.vision_raw, &result.vision_compensated})
      if (*error) **error -= shift;
  }
  return turn;
}

}  // namespace

ExperimentReport run_experiment(const ExperimentRequest& request, CellDevices& devices) {
  if (!devices.true_tip())
    throw InputError(
        request.cell.file.string() +
        ": is no virtual cell; this experiment needs the truth of one to judge itself");
  begin_experiment(request);
  const ExperimentPlan plan = experiment_plan(request.cell, request.seed, request.size);
  write_file(request.out / "plan.csv", plan_text(plan.rows));
  spdlog::info(fmt::format("recording {} positions and board views", plan.rows.size()));
  RecordRequest to_record{request.cell, plan.rows, request.out / "recording"};
  to_record.on_bad_reading = BadReading::kSkip;
  const RecordReport recorded = record(to_record, devices);
  spdlog::info(fmt::format("{} frames, {} of them full; {} places were there before",
                           recorded.frames, recorded.full_frames, recorded.present));
  const RecordedCell recording = read_recorded_cell(request.out / "recording", request.board);
  const auto [ours, visp, paper] = calibrate_chains(request, recording);
  const std::vector<TargetRow> targets = control_targets(request.cell.workspace, request.size);
  ExperimentReport report;
  report.circles = control_circles(request.cell.workspace, request.size);
  report.ours = close_loop(ours, true, targets, request.out, devices);
  report.paper = close_loop(paper, true, targets, request.out, devices);
  report.paper_no_map = close_loop(paper, false, targets, request.out, devices);
  report.visp = close_loop(visp, false, targets, request.out, devices);
  if (request.uses_tracker)
    report.tables = map_tables(ours, paper, plan);
  else
    report.turn_taken_out = take_out_turn(report.ours);
  report.recorded = figure_data(paper, plan, recording);
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
  ChainSettings settings = our_settings(request);
  settings.name = "prediction";
  const CalibratedChain chain = calibrate_chain(
      settings, request.cell, read_recorded_cell(recording, request.board), request.out);
  return predict_positioning(prediction_inputs(chain),
                             control_targets(request.cell.workspace, request.size));
}

}  // namespace planar
