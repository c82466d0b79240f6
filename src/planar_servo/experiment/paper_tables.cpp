#include "planar_servo/experiment/paper_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/experiment/paper_figures.h"
#include "planar_servo/offline/map/check_error_map.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"

namespace planar {
namespace {

[[noreturn]] void refuse_empty_circle(int radius_mm) {
  throw WorkError(
      fmt::format("no place on the circle of radius {} mm has both lamps and a tracker "
                  "reading; lamps.csv says why",
                  radius_mm));
}

std::string label_of(int radius_mm) {
  return fmt::format("radius {} mm", radius_mm);
}

/// Finds the pairs of a recording by their place.
class PairsOnCircles {
 public:
  PairsOnCircles(const std::vector<PairRow>& pairs, const std::vector<CirclePoint>& points)
      : points_(points) {
    for (const PairRow& pair : pairs) by_id_.emplace(pair.id, &pair);
  }

  /// Returns the pairs of a circle that checks the maps, in its order.
  std::vector<PairRow> check_circle(int radius_mm) const {
    std::vector<PairRow> pairs;
    for (const CirclePoint& point : points_)
      if (point.run == 0 && point.radius_mm == radius_mm)
        if (const PairRow* pair = pair_at(point)) pairs.push_back(*pair);
    if (pairs.empty()) refuse_empty_circle(radius_mm);
    return pairs;
  }

  /// Returns the places of one circle that every run has.
  std::vector<std::array<const PairRow*, kRuns>> of_all_runs(int radius_mm) const {
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

 private:
  const PairRow* pair_at(const CirclePoint& point) const {
    const auto found = by_id_.find(point.id);
    return found == by_id_.end() ? nullptr : found->second;
  }

  const std::vector<CirclePoint>& points_;
  std::map<std::string, const PairRow*> by_id_;
};

/// Holds a calibrated chain and its pairs on the circles.
struct JudgedChain {
  JudgedChain(const CalibratedChain& judged, const std::vector<CirclePoint>& points)
      : chain(judged),
        idw(fit_error_map_to_pairs(judged.pairs, {MapMethod::kIdw, 0.0}).result.map),
        circles(judged.pairs, points) {}

  const CalibratedChain& chain;
  ErrorMap idw;
  PairsOnCircles circles;
};

/// Returns the mean correlation between the error components of the three runs over one circle.
double run_correlation(const JudgedChain& judged, int radius_mm) {
  std::array<std::vector<double>, kRuns> runs;
  for (const auto& pairs : judged.circles.of_all_runs(radius_mm))
    for (std::size_t run = 0; run < runs.size(); ++run)
      for (int axis = 0; axis < 2; ++axis) runs[run].push_back(pairs[run]->error()[axis]);
  return (correlation(runs[0], runs[1]) + correlation(runs[0], runs[2]) +
          correlation(runs[1], runs[2])) /
         3.0;
}

/// Returns the largest standard deviation over the points of one circle, metres. At each point it
/// is that of the lengths of the errors that the map predicts from the three runs.
double prediction_repeatability(const JudgedChain& judged, int radius_mm) {
  double largest = 0.0;
  for (const auto& pairs : judged.circles.of_all_runs(radius_mm)) {
    Eigen::Vector3d lengths;
    for (std::size_t run = 0; run < pairs.size(); ++run)
      lengths[static_cast<int>(run)] =
          predict(judged.chain.map->map, pairs[run]->p_vision, pairs[run]->phi).error.norm();
    const double sigma = std::sqrt((lengths.array() - lengths.mean()).square().sum() / 2.0);
    largest = std::max(largest, sigma);
  }
  return largest;
}

/// Returns the paper's accuracy, which is blind to direction, of a map on one of the check circles.
double circle_accuracy(const JudgedChain& judged, const ErrorMap& map, int radius_mm) {
  return check_error_map(map, judged.circles.check_circle(radius_mm)).a2;
}

/// Says what went into the maps, and how they judge places that they were not fitted to.
std::vector<ComparisonRow> map_sources(const CalibratedChain& ours, const CalibratedChain& paper) {
  constexpr double kNotPrinted = std::numeric_limits<double>::quiet_NaN();
  const auto test = [](const CalibratedChain& chain) {
    return check_error_map(chain.map->map, pairs_to_check(chain.pairs, {Plan::kTest}));
  };
  const MapCheck our_test = test(ours), paper_test = test(paper);
  return {{"training positions", static_cast<double>(ours.map->n_used),
           static_cast<double>(paper.map->n_used), kPaperTrainingPlaces},
          {"test positions", static_cast<double>(our_test.raw.n),
           static_cast<double>(paper_test.raw.n), kPaperTestPlaces},
          {"vision error at the test positions, mm rms", our_test.raw.rms / kMillimetre,
           paper_test.raw.rms / kMillimetre, kNotPrinted},
          {"with the map, mm rms", our_test.compensated.rms / kMillimetre,
           paper_test.compensated.rms / kMillimetre, kNotPrinted}};
}

/// Returns the mean over the circles of a table.
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

}  // namespace

PaperTables map_tables(const CalibratedChain& ours, const CalibratedChain& paper,
                       const ExperimentPlan& plan) {
  const JudgedChain our(ours, plan.circle_points), their(paper, plan.circle_points);
  PaperTables tables;
  for (std::size_t i = 0; i < plan.circles.run_mm.size(); ++i) {
    const int radius_mm = plan.circles.run_mm[i];
    tables.run_correlation.push_back({label_of(radius_mm), run_correlation(our, radius_mm),
                                      run_correlation(their, radius_mm), kPaperCorrelation[i]});
    tables.repeatability.push_back({label_of(radius_mm), prediction_repeatability(our, radius_mm),
                                    prediction_repeatability(their, radius_mm),
                                    kPaperRepeatability_mm * kMillimetre});
  }
  for (std::size_t i = 0; i < plan.circles.check_mm.size(); ++i) {
    const int radius_mm = plan.circles.check_mm[i];
    tables.idw_accuracy.push_back({label_of(radius_mm), circle_accuracy(our, our.idw, radius_mm),
                                   circle_accuracy(their, their.idw, radius_mm), kPaperIdw[i]});
    tables.rbf_accuracy.push_back(
        {label_of(radius_mm), circle_accuracy(our, ours.map->map, radius_mm),
         circle_accuracy(their, paper.map->map, radius_mm), kPaperRbf[i]});
  }
  tables.map_sources = map_sources(ours, paper);
  tables.mean_accuracy = {mean_row("IDW", tables.idw_accuracy),
                          mean_row("RBF", tables.rbf_accuracy)};
  return tables;
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

std::vector<ComparisonRow> positioning_table(const std::vector<ControlCircle>& circles,
                                             const std::vector<TargetResult>& ours,
                                             const std::vector<TargetResult>& paper) {
  std::vector<ComparisonRow> rows;
  for (std::size_t i = 0; i < circles.size(); ++i) {
    const Eigen::Vector2d center_mm = circles[i].center / kMillimetre;
    rows.push_back({fmt::format("({:.0f}, {:.0f}) mm", center_mm.x(), center_mm.y()),
                    mean_error(results_on(circles[i], ours), &TargetResult::after_truth),
                    mean_error(results_on(circles[i], paper), &TargetResult::after_truth),
                    kPaperAfter_mm[i] * kMillimetre});
  }
  return rows;
}

}  // namespace planar
