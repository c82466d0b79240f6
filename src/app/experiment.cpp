#include "app/experiment.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <functional>
#include <map>

#include "app/check_error_map.h"
#include "app/experiment_plan.h"
#include "app/fit_error_map.h"
#include "app/recorder.h"
#include "core/error.h"
#include "core/units.h"
#include "text/atomic_file.h"
#include "text/growing_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

// What the paper prints.
constexpr double kPaperCorrelation[] = {0.991, 0.996, 0.993, 0.995};
constexpr double kPaperIdw[] = {0.657, 0.796, 0.853};
constexpr double kPaperRbf[] = {0.905, 0.876, 0.953};
constexpr double kPaperAfter_mm[] = {0.185, 0.174, 0.180, 0.176};

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

/// Mean correlation between the error components of the three runs over one circle.
double run_correlation(const std::vector<PairRow>& pairs, int radius_mm) {
  std::map<std::string, std::vector<const PairRow*>> by_point;
  for (const PairRow& pair : pairs) {
    const std::string mark = fmt::format("_r{}_", radius_mm);
    const auto at = pair.id.find(mark);
    if (pair.id.rfind("run", 0) == 0 && at != std::string::npos)
      by_point[pair.id.substr(at + mark.size())].push_back(&pair);
  }
  std::vector<double> runs[3];
  for (const auto& [point, rows] : by_point) {
    if (rows.size() != 3) continue;
    for (std::size_t run = 0; run < 3; ++run)
      for (int axis = 0; axis < 2; ++axis) runs[run].push_back(rows[run]->error()[axis]);
  }
  if (runs[0].empty()) refuse_empty_circle(radius_mm);
  return (correlation(runs[0], runs[1]) + correlation(runs[0], runs[2]) +
          correlation(runs[1], runs[2])) /
         3.0;
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

void fill_tables(ExperimentReport& report, const CalibratedChain& ours,
                 const CalibratedChain& paper) {
  for (int i = 0; i < 4; ++i) {
    const int radius_mm = 100 * (i + 1);
    report.table1.push_back({fmt::format("radius {} mm", radius_mm),
                             run_correlation(ours.pairs, radius_mm),
                             run_correlation(paper.pairs, radius_mm), kPaperCorrelation[i]});
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
  return report;
}

}  // namespace planar
