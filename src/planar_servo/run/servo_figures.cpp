#include "planar_servo/run/servo_figures.h"

#include <limits>

namespace planar {
namespace {

std::optional<Summary> summary_of(const std::vector<TargetResult>& results, TargetError error) {
  const std::vector<double> lengths = error_lengths(results, error);
  if (lengths.empty()) return std::nullopt;
  return summarize(lengths);
}

std::optional<double> coverage_of(const std::vector<TargetResult>& results) {
  constexpr double kSigmas = 1.96;
  Eigen::Index within = 0, all = 0;
  for (const TargetResult& result : results) {
    if (!result.vision_compensated || !result.uncertainty_m) continue;
    within += (result.vision_compensated->array().abs() < kSigmas * *result.uncertainty_m).count();
    all += 2;
  }
  if (all == 0) return std::nullopt;
  return static_cast<double>(within) / static_cast<double>(all);
}

}  // namespace

std::vector<double> error_lengths(const std::vector<TargetResult>& results, TargetError error) {
  std::vector<double> lengths;
  for (const TargetResult& result : results)
    if (result.*error) lengths.push_back((result.*error)->norm());
  return lengths;
}

double mean_error(const std::vector<TargetResult>& results, TargetError error) {
  const std::vector<double> lengths = error_lengths(results, error);
  return lengths.empty() ? std::numeric_limits<double>::quiet_NaN() : mean(lengths);
}

ServoFigures figures_of(const std::vector<TargetResult>& results) {
  ServoFigures figures;
  figures.targets = results.size();
  std::vector<double> iterations, seconds;
  for (const TargetResult& result : results) {
    if (result.status == ServoStatus::kReached) ++figures.reached;
    iterations.push_back(result.iterations);
    seconds.push_back(result.seconds);
  }
  if (results.empty()) return figures;
  figures.iterations_median = median(iterations);
  figures.seconds_per_target = mean(seconds);
  figures.before_own = summary_of(results, &TargetResult::before_own);
  figures.after_own = summary_of(results, &TargetResult::after_own);
  figures.before_truth = summary_of(results, &TargetResult::before_truth);
  figures.after_truth = summary_of(results, &TargetResult::after_truth);
  figures.coverage_95 = coverage_of(results);
  return figures;
}

}  // namespace planar
