#include "planar_servo/experiment/paper_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/work/run/servo_report.h"

namespace planar {
namespace {

// Further figures that the paper prints: circles in the order of its tables, lengths in
// millimetres.
constexpr double kPaperCorrelation[] = {0.991, 0.996, 0.993, 0.995};  // table 1
constexpr double kPaperIdw[] = {0.657, 0.796, 0.853};                 // table 2
constexpr double kPaperTrainingPlaces = 200, kPaperTestPlaces = 30;   // table 3
constexpr double kPaperRepeatability_mm = 0.004;                      // table 4: "less than"
constexpr double kPaperRbf[] = {0.905, 0.876, 0.953};                 // table 5
constexpr double kPaperAfter_mm[] = {0.185, 0.174, 0.180, 0.176};     // table 7
constexpr double kPaperImprovement[] = {0.877, 0.872, 0.857, 0.851};  // table 7
constexpr double kPaperBeforeMean_mm = 1.318;                         // of the four circles
constexpr double kPaperImprovementMean = 0.864;                       // of the four circles

[[noreturn]] void refuse_empty_circle(int radius_mm) {
  throw WorkError(
      {fmt::format("no place on the circle of radius {} mm has both lamps and a tracker reading",
                   radius_mm),
       "lamps.csv says why", "", Cause::kInsufficient});
}

constexpr double kNotPrinted = std::numeric_limits<double>::quiet_NaN();

std::string label_of(int radius_mm) {
  return fmt::format("radius {} mm", radius_mm);
}

/// Returns the lengths of the errors that a chain's map predicts from each frame alone, by the id
/// of the place.
std::map<std::string, std::vector<double>> predictions_by_frame(const CalibratedChain& chain) {
  const VisionCalibration vision = read_vision(chain.cell, false);
  std::map<std::string, std::vector<double>> lengths;
  for (const LampRow& row : read_lamps(chain.folder / "lamps.csv")) {
    if (row.status != LampStatus::kOk || row.uv_px.size() != 2) continue;
    const auto place = see_tool(vision, observation_of(row));
    if (!place) continue;
    const TipPose& seen = place->seen.tip;
    lengths[row.id].push_back(predict_error(chain.map->map, seen.p, seen.phi).norm());
  }
  return lengths;
}

/// Holds a calibrated chain and its pairs on the circles.
struct ComparedChain {
  ComparedChain(const CalibratedChain& compared, const std::vector<CirclePoint>& points)
      : chain(compared),
        idw(fit_error_map_to_pairs(compared.pairs, {MapMethod::kIdw, 0.0}).result.map),
        circles(compared.pairs, points),
        by_frame(predictions_by_frame(compared)) {}

  const CalibratedChain& chain;
  ErrorMap idw;
  PairsOnCircles circles;
  std::map<std::string, std::vector<double>> by_frame;  ///< see predictions_by_frame()
};

/// Returns the mean correlation between the error components of the three runs over one circle.
double run_correlation(const ComparedChain& compared, int radius_mm) {
  std::array<std::vector<double>, kRuns> runs;
  for (const auto& pairs : compared.circles.of_all_runs(radius_mm))
    for (std::size_t run = 0; run < runs.size(); ++run)
      for (int axis = 0; axis < 2; ++axis) runs[run].push_back(pairs[run]->error()[axis]);
  return (correlation(runs[0], runs[1]) + correlation(runs[0], runs[2]) +
          correlation(runs[1], runs[2])) /
         3.0;
}

/// Returns the largest standard deviation over the points of one check circle, metres. At each
/// point it is that of what the map predicts from each of its frames. NaN where no point has two.
double prediction_repeatability(const ComparedChain& compared, int radius_mm) {
  double largest = kNotPrinted;
  for (const PairRow& pair : compared.circles.check_circle(radius_mm))
    if (const auto found = compared.by_frame.find(pair.id); found != compared.by_frame.end())
      largest = std::fmax(largest, standard_deviation(found->second));
  return largest;
}

Accuracy circle_accuracy(const ComparedChain& compared, const ErrorMap& map, int radius_mm) {
  const MapCheck check = check_error_map(map, compared.circles.check_circle(radius_mm));
  return {check.a1, check.a2};
}

/// Returns how many radial functions a map has, and their width in mm; NaN for a map without.
std::array<double, 2> functions_of(const ErrorMap& map) {
  if (const auto* rbf = std::get_if<RbfMap>(&map))
    return {static_cast<double>(rbf->parameters().centers.cols()),
            mm(rbf->parameters().kernel.width)};
  if (const auto* sparse = std::get_if<SparseRbfMap>(&map))
    return {static_cast<double>(sparse->parameters().centers.cols()),
            mm(sparse->parameters().width)};
  return {kNotPrinted, kNotPrinted};
}

/// Says what went into the maps, and how well they predict places that they were not fitted to.
std::vector<ComparisonRow> map_sources(const CalibratedChain& ours, const CalibratedChain& paper) {
  const auto test = [](const CalibratedChain& chain) {
    return check_error_map(chain.map->map, pairs_to_check(chain.pairs, {Purpose::kTest}));
  };
  const MapCheck our_test = test(ours), paper_test = test(paper);
  const auto [our_count, our_width_mm] = functions_of(ours.map->map);
  const auto [paper_count, paper_width_mm] = functions_of(paper.map->map);
  return {{"training positions", static_cast<double>(ours.map->n_used),
           static_cast<double>(paper.map->n_used), kPaperTrainingPlaces},
          {"test positions", static_cast<double>(our_test.raw.n),
           static_cast<double>(paper_test.raw.n), kPaperTestPlaces},
          {"vision error at the test positions, mm rms", mm(our_test.raw.rms),
           mm(paper_test.raw.rms), kNotPrinted},
          {"with the map, mm rms", mm(our_test.compensated.rms), mm(paper_test.compensated.rms),
           kNotPrinted},
          {"centres of the radial functions", our_count, paper_count, kNotPrinted},
          {"their width, mm", our_width_mm, paper_width_mm, kNotPrinted}};
}

/// Returns the mean over the circles of a table.
AccuracyRow mean_row(const std::string& label, const std::vector<AccuracyRow>& rows) {
  AccuracyRow sum{label, {}, {}, 0.0};
  const double n = static_cast<double>(rows.size());
  for (const AccuracyRow& row : rows) {
    sum.ours.a1 += row.ours.a1 / n;
    sum.ours.a2 += row.ours.a2 / n;
    sum.paper_chain.a1 += row.paper_chain.a1 / n;
    sum.paper_chain.a2 += row.paper_chain.a2 / n;
    sum.paper += row.paper / n;
  }
  return sum;
}

std::vector<TargetResult> results_on(const ControlCircle& circle,
                                     const std::vector<TargetResult>& results) {
  std::vector<TargetResult> found;
  for (const TargetResult& result : results)
    if (std::any_of(circle.targets.begin(), circle.targets.end(),
                    [&](const TargetRow& target) { return target.id == result.id; }))
      found.push_back(result);
  return found;
}

}  // namespace

PairsOnCircles::PairsOnCircles(const std::vector<PairRow>& pairs,
                               const std::vector<CirclePoint>& points)
    : points_(points) {
  for (const PairRow& pair : pairs) by_id_.emplace(pair.id, &pair);
}

std::vector<PairRow> PairsOnCircles::check_circle(int radius_mm) const {
  std::vector<PairRow> pairs;
  for (const CirclePoint& point : points_)
    if (point.run == 0 && point.radius_mm == radius_mm)
      if (const PairRow* pair = pair_at(point)) pairs.push_back(*pair);
  if (pairs.empty()) refuse_empty_circle(radius_mm);
  return pairs;
}

std::vector<std::array<const PairRow*, kRuns>> PairsOnCircles::of_all_runs(int radius_mm) const {
  std::map<int, std::array<const PairRow*, kRuns>> by_index;
  for (const CirclePoint& point : points_)
    if (point.run > 0 && point.radius_mm == radius_mm)
      by_index[point.index].at(static_cast<std::size_t>(point.run - 1)) = pair_at(point);
  std::vector<std::array<const PairRow*, kRuns>> complete;
  for (const auto& [index, pairs] : by_index)
    if (std::count(pairs.begin(), pairs.end(), nullptr) == 0) complete.push_back(pairs);
  if (complete.empty()) refuse_empty_circle(radius_mm);
  return complete;
}

const PairRow* PairsOnCircles::pair_at(const CirclePoint& point) const {
  const auto found = by_id_.find(point.id);
  return found == by_id_.end() ? nullptr : found->second;
}

PaperTables map_tables(const CalibratedChain& ours, const CalibratedChain& paper,
                       const ExperimentPlan& plan) {
  const ComparedChain our(ours, plan.circle_points), their(paper, plan.circle_points);
  PaperTables tables;
  for (std::size_t i = 0; i < plan.circles.run_mm.size(); ++i) {
    const int radius_mm = plan.circles.run_mm[i];
    tables.run_correlation.push_back({label_of(radius_mm), run_correlation(our, radius_mm),
                                      run_correlation(their, radius_mm), kPaperCorrelation[i]});
  }
  for (std::size_t i = 0; i < plan.circles.check_mm.size(); ++i) {
    const int radius_mm = plan.circles.check_mm[i];
    tables.idw_accuracy.push_back({label_of(radius_mm), circle_accuracy(our, our.idw, radius_mm),
                                   circle_accuracy(their, their.idw, radius_mm), kPaperIdw[i]});
    tables.rbf_accuracy.push_back(
        {label_of(radius_mm), circle_accuracy(our, ours.map->map, radius_mm),
         circle_accuracy(their, paper.map->map, radius_mm), kPaperRbf[i]});
    tables.repeatability.push_back({label_of(radius_mm), prediction_repeatability(our, radius_mm),
                                    prediction_repeatability(their, radius_mm),
                                    kPaperRepeatability_mm * kMillimetre});
  }
  tables.map_sources = map_sources(ours, paper);
  tables.mean_accuracy = {mean_row("IDW", tables.idw_accuracy),
                          mean_row("RBF", tables.rbf_accuracy)};
  return tables;
}

std::vector<PositioningRow> positioning_table(const std::vector<ControlCircle>& circles,
                                              const std::vector<TargetResult>& ours,
                                              const std::vector<TargetResult>& paper) {
  const auto row = [](const std::string& label, const std::vector<TargetResult>& our,
                      const std::vector<TargetResult>& their) {
    return PositioningRow{label, mean_error(their, &TargetResult::before_judged),
                          mean_error(our, &TargetResult::after_judged),
                          mean_error(their, &TargetResult::after_judged)};
  };
  std::vector<PositioningRow> rows;
  for (std::size_t i = 0; i < circles.size(); ++i) {
    const Eigen::Vector2d center_mm = circles[i].center / kMillimetre;
    rows.push_back(row(fmt::format("({:.0f}, {:.0f}) mm", center_mm.x(), center_mm.y()),
                       results_on(circles[i], ours), results_on(circles[i], paper)));
    rows.back().paper_after = kPaperAfter_mm[i] * kMillimetre;
    rows.back().paper_improvement = kPaperImprovement[i];
    rows.back().paper_before = rows.back().paper_after / (1.0 - kPaperImprovement[i]);
  }
  rows.push_back(row("all four", ours, paper));
  rows.back().paper_before = kPaperBeforeMean_mm * kMillimetre;
  rows.back().paper_after = kPaperAfterMean_mm * kMillimetre;
  rows.back().paper_improvement = kPaperImprovementMean;
  return rows;
}

}  // namespace planar
