#include "planar_servo/experiment/experiment.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/experiment/experiment_plan.h"
#include "planar_servo/experiment/paper_figures.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/offline/map/check_error_map.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/offline/record/recorder.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_empty_circle(int radius_mm) {
  throw WorkError(
      fmt::format("no place on the circle of radius {} mm has both lamps and a tracker "
                  "reading; lamps.csv says why",
                  radius_mm));
}

/// The pairs whose ids begin with `prefix`, in the recording's order.
std::vector<PairRow> pairs_with_prefix(const std::vector<PairRow>& pairs,
                                       const std::string& prefix) {
  std::vector<PairRow> found;
  for (const PairRow& pair : pairs)
    if (pair.id.rfind(prefix, 0) == 0) found.push_back(pair);
  return found;
}

/// The rows of one circle that each of the three runs has, point by point.
std::vector<std::array<const PairRow*, 3>> rows_of_runs(const std::vector<PairRow>& pairs,
                                                        int radius_mm) {
  std::map<std::string, std::vector<const PairRow*>> by_point;
  for (const PairRow& pair : pairs) {
    const std::string mark = fmt::format("_r{}_", radius_mm);
    const auto at = pair.id.find(mark);
    if (pair.id.rfind("run", 0) == 0 && at != std::string::npos)
      by_point[pair.id.substr(at + mark.size())].push_back(&pair);
  }
  std::vector<std::array<const PairRow*, 3>> complete;
  for (const auto& [point, rows] : by_point)
    if (rows.size() == 3) complete.push_back({rows[0], rows[1], rows[2]});
  if (complete.empty()) refuse_empty_circle(radius_mm);
  return complete;
}

/// Mean correlation between the error components of the three runs over one circle.
double run_correlation(const std::vector<PairRow>& pairs, int radius_mm) {
  std::vector<double> runs[3];
  for (const auto& rows : rows_of_runs(pairs, radius_mm))
    for (std::size_t run = 0; run < 3; ++run)
      for (int axis = 0; axis < 2; ++axis) runs[run].push_back(rows[run]->error()[axis]);
  return (correlation(runs[0], runs[1]) + correlation(runs[0], runs[2]) +
          correlation(runs[1], runs[2])) /
         3.0;
}

/// The largest standard deviation, over the points of one circle, of the length of the error that
/// the map predicts from each of the three runs.
double prediction_repeatability(const ErrorMap& map, const std::vector<PairRow>& pairs,
                                int radius_mm) {
  double largest = 0.0;
  for (const auto& rows : rows_of_runs(pairs, radius_mm)) {
    Eigen::Vector3d lengths;
    for (std::size_t run = 0; run < 3; ++run)
      lengths[static_cast<int>(run)] =
          predict(map, rows[run]->p_vision, rows[run]->phi).error.norm();
    const double sigma = std::sqrt((lengths.array() - lengths.mean()).square().sum() / 2.0);
    largest = std::max(largest, sigma);
  }
  return largest;
}

/// The paper's accuracy (blind to direction) of a map on one of its check circles.
double circle_accuracy(const ErrorMap& map, const std::vector<PairRow>& pairs, int radius_mm) {
  const std::vector<PairRow> circle = pairs_with_prefix(pairs, fmt::format("r{}_", radius_mm));
  if (circle.empty()) refuse_empty_circle(radius_mm);
  return check_error_map(map, circle).a2;
}

ErrorMap idw_of(const CalibratedChain& chain) {
  return fit_error_map_to_pairs(chain.pairs, {MapMethod::kIdw, 0.0}).result.map;
}

/// What went into the maps, and how they judge places that they were not fitted to.
std::vector<ComparisonRow> map_table(const CalibratedChain& ours, const CalibratedChain& paper) {
  constexpr double kNotPrinted = std::numeric_limits<double>::quiet_NaN();
  const auto test = [](const CalibratedChain& chain) {
    return check_error_map(chain.map.map, pairs_to_check(chain.pairs, {"test"}));
  };
  const MapCheck our_test = test(ours), paper_test = test(paper);
  return {{"training positions", static_cast<double>(ours.map.n_used),
           static_cast<double>(paper.map.n_used), kPaperTrainingPlaces},
          {"test positions", static_cast<double>(our_test.raw.n),
           static_cast<double>(paper_test.raw.n), kPaperTestPlaces},
          {"vision error at the test positions, mm rms", our_test.raw.rms / kMillimetre,
           paper_test.raw.rms / kMillimetre, kNotPrinted},
          {"with the map, mm rms", our_test.compensated.rms / kMillimetre,
           paper_test.compensated.rms / kMillimetre, kNotPrinted}};
}

/// The mean over the circles of a table.
ComparisonRow mean_row(const std::string& label, const std::vector<ComparisonRow>& rows) {
  ComparisonRow sum{label, 0.0, 0.0, 0.0};
  const double n = static_cast<double>(rows.size());
  for (const ComparisonRow& row : rows) {
    sum.ours += row.ours / n;
    sum.paper_chain += row.paper_chain / n;
    sum.paper += row.paper / n;
  }
  return sum;
}

void fill_tables(ExperimentReport& report, const CalibratedChain& ours,
                 const CalibratedChain& paper) {
  for (int i = 0; i < 4; ++i) {
    const int radius_mm = 100 * (i + 1);
    report.table1.push_back({fmt::format("radius {} mm", radius_mm),
                             run_correlation(ours.pairs, radius_mm),
                             run_correlation(paper.pairs, radius_mm), kPaperCorrelation[i]});
    report.table4.push_back({fmt::format("radius {} mm", radius_mm),
                             prediction_repeatability(ours.map.map, ours.pairs, radius_mm),
                             prediction_repeatability(paper.map.map, paper.pairs, radius_mm),
                             kPaperRepeatability_mm * kMillimetre});
  }
  const ErrorMap our_idw = idw_of(ours), paper_idw = idw_of(paper);
  for (int i = 0; i < 3; ++i) {
    const int radius_mm = 150 + 100 * i;
    const std::string label = fmt::format("radius {} mm", radius_mm);
    report.table2.push_back({label, circle_accuracy(our_idw, ours.pairs, radius_mm),
                             circle_accuracy(paper_idw, paper.pairs, radius_mm), kPaperIdw[i]});
    report.table5.push_back({label, circle_accuracy(ours.map.map, ours.pairs, radius_mm),
                             circle_accuracy(paper.map.map, paper.pairs, radius_mm), kPaperRbf[i]});
  }
  report.table3 = map_table(ours, paper);
  report.table6 = {mean_row("IDW", report.table2), mean_row("RBF", report.table5)};
  int circle = 0;
  for (const Eigen::Vector2d& center : control_centers()) {
    ++circle;
    report.table7.push_back(
        {fmt::format("({:.0f}, {:.0f}) mm", center.x() / kMillimetre, center.y() / kMillimetre),
         mean_error(report.ours, &TargetResult::after_truth, control_id_prefix(circle)),
         mean_error(report.paper, &TargetResult::after_truth, control_id_prefix(circle)),
         kPaperAfter_mm[circle - 1] * kMillimetre});
  }
}

std::vector<TargetResult> close_loop(const CalibratedChain& chain, bool with_map,
                                     const fs::path& out, CellDevices& devices) {
  ServoRequest request;
  request.cell = chain.cell;
  request.center = chain.settings.center;
  request.use_error_map = with_map;
  request.out = out / chain.settings.name / (with_map ? "run" : "run_without_map");
  const std::vector<TargetRow> targets = control_targets();
  spdlog::info("closing the loop over {} targets: {}, {}", targets.size(), chain.settings.name,
               with_map ? "with its error map" : "without an error map");
  ServoRun run(request, devices);
  return run_servo(run, targets);
}

}  // namespace

ExperimentReport run_experiment(const ExperimentRequest& request, CellDevices& devices) {
  if (!devices.true_tip())
    throw InputError(request.cell.file.string() +
                     ": is no virtual cell; this experiment is judged by a truth");
  if (fs::exists(request.out / "recording"))
    throw InputError(request.out.string() + ": holds an experiment already; name another folder");
  make_folder(request.out);
  const std::vector<PlanRow> plan = experiment_plan(request.cell, request.seed);
  write_file(request.out / "plan.csv", plan_text(plan));
  spdlog::info("recording {} positions and board views", plan.size());
  const RecordReport recorded = record({request.cell, plan, request.out / "recording"}, devices);
  spdlog::info("{} frames, {} of them full", recorded.frames, recorded.full_frames);
  const RecordedCell recording = read_recorded_cell(request.out / "recording", request.board);
  const CalibratedChain ours =
      calibrate_chain(our_chain(request.cell), request.cell, recording, request.out);
  const CalibratedChain paper =
      calibrate_chain(paper_chain(request.cell), request.cell, recording, request.out);
  ExperimentReport report;
  report.ours = close_loop(ours, true, request.out, devices);
  report.paper = close_loop(paper, true, request.out, devices);
  report.paper_no_map = close_loop(paper, false, request.out, devices);
  fill_tables(report, ours, paper);
  report.prediction = predict_positioning(ours, control_targets());
  return report;
}

PositioningPrediction predict_experiment(const ExperimentRequest& request) {
  const fs::path recording = request.out / "recording";
  if (!fs::exists(recording))
    throw InputError(recording.string() +
                     ": is not there; --predict judges the recording of an experiment or of "
                     "planar-record");
  ChainSettings settings = our_chain(request.cell);
  settings.name = "prediction";
  return predict_positioning(
      calibrate_chain(settings, request.cell, read_recorded_cell(recording, request.board),
                      request.out),
      control_targets());
}

}  // namespace planar
