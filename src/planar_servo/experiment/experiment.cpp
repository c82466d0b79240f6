#include "planar_servo/experiment/experiment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <future>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/machine/judge/cell_judge.h"
#include "planar_servo/work/record/recorder.h"
#include "planar_servo/work/run/run_files.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

fs::path run_folder(const ExperimentRequest& experiment, const std::string& chain, bool with_map) {
  return experiment.out / chain / (with_map ? "run" : "run_without_map");
}

/// Returns whether an experiment has begun to close the loop with our chain. Its recording is
/// complete then, and must not grow any more: the chains were calibrated from it.
bool has_begun_loop(const ExperimentRequest& experiment) {
  ServoRequest loop;
  loop.folder.path = run_folder(experiment, our_chain(experiment.cell).name, true);
  return fs::exists(results_file(loop));
}

/// Returns the loop's chain and folder, as in "ours run".
std::string name_of(const ServoRequest& loop) {
  return fmt::format("{} {}", loop.folder.path.parent_path().filename().string(),
                     loop.folder.path.filename().string());
}

/// Moves to the targets that have no result yet and returns the results of all.
std::vector<TargetResult> close_loop(const ServoRequest& loop,
                                     const std::vector<TargetRow>& targets, CellDevices& devices) {
  const std::string chain = loop.folder.path.parent_path().filename().string();
  const std::string map =
      uses_error_map(*loop.cell) ? "with its error map" : "without an error map";
  spdlog::info(fmt::format("closing the loop over {} targets: {}, {}", targets.size(), chain, map));
  ServoRun run(loop, devices);
  return run_servo(run, targets);
}

ChainSettings our_settings(const ExperimentRequest& request) {
  ChainSettings settings = our_chain(request.cell);
  settings.uses_tracker = request.uses_tracker;
  settings.dots_height = request.dots_height;
  settings.accept_step = request.accept_step;
  settings.accept_map = request.accept_map;
  return settings;
}

struct CalibratedChains {
  CalibratedChain ours, visp, paper;
};

/// Calibrates the paper's chain at the same time as our chain and then ViSP's. These two may both
/// use vpCalibration, whose settings are global.
CalibratedChains calibrate_chains(const ExperimentRequest& request, const RecordedCell& recording) {
  const auto calibrate = [&](ChainSettings settings) {
    settings.accept_step = request.accept_step;
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
    if (!result.after_judged) continue;
    const Eigen::Vector2d p = result.p_d + *result.after_judged;
    sum += Eigen::Vector2d(p.dot(result.p_d), p.x() * result.p_d.y() - p.y() * result.p_d.x());
  }
  const double turn = std::atan2(sum.y(), sum.x());
  for (TargetResult& result : results) {
    if (!result.after_judged) continue;
    const auto moved_by = [&](const Eigen::Vector2d& error) -> Eigen::Vector2d {
      const Eigen::Vector2d p = result.p_d + error;
      return rotation2d(turn) * p - p;
    };
    const Eigen::Vector2d shift = moved_by(*result.after_judged);
    if (result.before_judged) *result.before_judged += moved_by(*result.before_judged);
    *result.after_judged += shift;
    for (auto* error : {&result.vision_raw, &result.vision_compensated, &result.believed})
      if (*error) **error -= shift;
  }
  return turn;
}

/// Throws InputError for a cell without a truth that its tracker cannot judge.
void require_judge(const ExperimentRequest& request) {
  require_judging_tracker(request.cell);
  if (!request.uses_tracker)
    throw InputError({"--train 0 is for virtual cells, whose truth judges it",
                      "let the calibration use readings, such as --train 40", request.cell.file});
}

/// Records what is missing of the plan, unless the loop has begun: nothing may join the recording
/// then.
RecordReport record_plan(const ExperimentRequest& request, const ExperimentPlan& plan,
                         CellDevices& devices) {
  if (has_begun_loop(request)) return {};
  spdlog::info(fmt::format("recording {} positions and board views", plan.rows.size()));
  RecordRequest to_record{request.cell, plan.rows, request.out / "recording"};
  to_record.stop = request.stop;
  to_record.on_bad_reading = BadReading::kSkip;
  to_record.board = request.board;
  to_record.display = request.display;
  to_record.may_home = request.may_home;
  RecordReport recorded = record(to_record, devices);
  spdlog::info(fmt::format("{} frames, {} of them full; {} places were there before",
                           recorded.frames, recorded.full_frames, recorded.present));
  if (!recorded.skipped.empty())
    spdlog::warn(fmt::format("left out without a reading: {}", fmt::join(recorded.skipped, ", ")));
  return recorded;
}

/// Closes the loop with every chain, with the paper's without its map as well. `monuments` are
/// those that nobody used to calibrate, if there are any.
void close_loops(const ExperimentRequest& request, const CalibratedChains& chains,
                 const std::vector<MonumentSeen>& monuments, CellDevices& devices,
                 ExperimentReport& report) {
  const std::vector<TargetRow> targets = control_targets(request.cell.workspace, request.size);
  std::array<ServoRequest, 4> loops{
      control_loop(chains.ours, true, request), control_loop(chains.paper, true, request),
      control_loop(chains.paper, false, request), control_loop(chains.visp, false, request)};
  std::shared_ptr<TrackerJudge> tracker;
  if (!devices.truth()) {
    tracker =
        std::make_shared<TrackerJudge>(request.cell, chains.ours.field.value().field.tool,
                                       devices.tracker(), request.out / "judge.csv", request.stop);
    report.reflector_sigma = tracker->common_sigma();
    // No camera takes part: the tool is supposed to be where the arm that our chain found has it.
    tracker->suppose(
        [cell = loops[0].cell](const Joints& theta_c) { return cell->planner.reached(theta_c); });
    const auto is_done = [&](const ServoRequest& loop) {
      return loop.folder.resume && results_so_far(loop).size() == targets.size();
    };
    if (!std::all_of(loops.begin(), loops.end(), is_done)) tracker->make_ready(monuments);
  }
  const auto close = [&](ServoRequest& loop) {
    loop.judge = tracker;
    if (tracker) tracker->name_loop(name_of(loop));
    return close_loop(loop, targets, devices);
  };
  report.ours = close(loops[0]);
  report.paper = close(loops[1]);
  report.paper_no_map = close(loops[2]);
  report.visp = close(loops[3]);
}

PositioningPrediction predicted(const ExperimentRequest& request, const CalibratedChain& ours) {
  return predict_positioning(
      prediction_inputs(ours.cell, ours.pairs, ours.field.value().landing_sigma),
      control_targets(request.cell.workspace, request.size));
}

std::string board_text(const Board& board) {
  return fmt::format("{}:{}x{}:{}mm", name_in(kBoardKinds, board.kind), board.columns, board.rows,
                     mm(board.pitch));
}

std::string value_text(const nlohmann::json& making, const std::string& key) {
  if (!making.contains(key)) return "none";
  const nlohmann::json& value = making[key];
  return value.is_string() ? value.get<std::string>().substr(0, 24) : value.dump();
}

}  // namespace

ServoRequest control_loop(const CalibratedChain& chain, bool with_map,
                          const ExperimentRequest& experiment) {
  ServoRequest loop;
  loop.cell = std::make_shared<CalibratedCell>(read_calibrated_cell(chain.cell, with_map));
  loop.policy.center = chain.settings.center;
  loop.policy.checks_health = loop.policy.guards_looks = chain.settings.is_guarded;
  loop.accepted.map = chain.settings.accept_map || !chain.settings.is_guarded;
  loop.policy.estimates_landings = chain.settings.estimates_landings;
  loop.accepted.doubts = true;  // a target that fails is a result, too
  loop.folder.path = run_folder(experiment, chain.settings.name, with_map);
  loop.folder.resume = fs::exists(results_file(loop));
  loop.may_home = experiment.may_home;
  loop.stop = experiment.stop;
  return loop;
}

ExperimentReport run_experiment(const ExperimentRequest& request, CellDevices& devices) {
  if (!devices.truth()) require_judge(request);
  begin_experiment(request);
  const ExperimentPlan plan = experiment_plan(request.cell, request.seed, request.size);
  write_file(request.out / "plan.csv", plan_text(plan.rows));
  const RecordReport recorded = record_plan(request, plan, devices);
  const RecordedCell recording = read_recorded_cell(request.out / "recording", request.board);
  const CalibratedChains chains = calibrate_chains(request, recording);
  ExperimentReport report;
  report.circles = control_circles(request.cell.workspace, request.size);
  close_loops(request, chains, recorded.monuments, devices, report);
  if (!request.uses_tracker)
    report.turn_taken_out = take_out_turn(report.ours);
  else if (!plan.circle_points.empty())
    report.tables = map_tables(chains.ours, chains.paper, plan);
  report.recorded = plot_data(chains.paper, plan, recording);
  report.tables.positioning = positioning_table(report.circles, report.ours, report.paper);
  report.prediction = predicted(request, chains.ours);
  return report;
}

PositioningPrediction predict_experiment(const ExperimentRequest& request) {
  const fs::path recording = request.out / "recording";
  if (!fs::exists(recording))
    throw InputError({"does not exist",
                      "--predict needs a recording there, of an experiment or of planar-record",
                      recording, Cause::kMissing});
  ChainSettings settings = our_settings(request);
  settings.name = "prediction";
  const CalibratedChain chain = calibrate_chain(
      settings, request.cell, read_recorded_cell(recording, request.board), request.out);
  return predicted(request, chain);
}

nlohmann::json making_of_campaign(const ExperimentRequest& request) {
  const ExperimentSize& size = request.size;
  nlohmann::json making{{"cell_sha256", content_sha256(request.cell.file)},
                        {"board", board_text(request.board)},
                        {"board_views", size.board_views},
                        {"sweep_points", size.sweep_points},
                        {"training_points", size.training_points},
                        {"test_points", size.test_points},
                        {"check_points", size.check_points},
                        {"run_points", size.run_points},
                        {"control_points", size.control_points},
                        {"unattended_poses", size.unattended_poses},
                        {"lays", size.lays},
                        {"uses_tracker", request.uses_tracker}};
  if (request.dots_height) making["board_thickness_mm"] = mm(*request.dots_height);
  return making;
}

void require_same_making(const fs::path& file, const nlohmann::json& begun,
                         const nlohmann::json& now) {
  nlohmann::json keys = begun;
  keys.update(now);
  std::vector<std::string> differences;
  for (const auto& item : keys.items()) {
    const std::string before = value_text(begun, item.key()), after = value_text(now, item.key());
    if (before != after)
      differences.push_back(fmt::format("{} {}, now {}", item.key(), before, after));
  }
  if (differences.empty()) return;
  throw InputError({fmt::format("was begun with another cell or other options: {}",
                                fmt::join(differences, "; ")),
                    "give the same ones to continue, or name another folder", file,
                    Cause::kForeign});
}

void begin_experiment(const ExperimentRequest& request) {
  const fs::path file = request.out / "begun.json";
  nlohmann::json now = making_of_campaign(request);
  now["seed"] = request.seed;
  if (request.cell.truth) now["truth_sha256"] = content_sha256(*request.cell.truth);
  if (!fs::exists(file)) {
    if (fs::exists(request.out / "recording") || fs::exists(request.out / "rows.jsonl"))
      throw InputError({"holds a recording or a campaign already", "name another folder",
                        request.out, Cause::kForeign});
    make_folder(request.out);
    return write_file(file, with_format_key("experiment_begun", now.dump(2)));
  }
  nlohmann::json begun = nlohmann::json::parse(read_file(file), nullptr, false);
  if (!begun.is_object())
    throw InputError(
        {"does not say what the experiment was begun with", "name another folder", file});
  begun.erase("format");
  require_same_making(file, begun, now);
}

}  // namespace planar
