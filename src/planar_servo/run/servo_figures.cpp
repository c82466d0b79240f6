#include "planar_servo/run/servo_figures.h"

#include <algorithm>
#include <cmath>
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
    const auto& believed = result.believed ? result.believed : result.vision_compensated;
    if (!believed || !result.uncertainty_m) continue;
    const double sigma = std::hypot(*result.uncertainty_m, result.sigma_truth_m.value_or(0.0));
    within += (believed->array().abs() < kSigmas * sigma).count();
    all += 2;
  }
  if (all == 0) return std::nullopt;
  return static_cast<double>(within) / static_cast<double>(all);
}

/// Returns whether vision made the true errors longer in the mean, by more than two standard
/// deviations of that mean.
bool made_worse(const std::vector<TargetResult>& results) {
  constexpr std::size_t kEnoughTargets = 5;
  constexpr double kSigmas = 2.0;
  std::vector<double> changes;
  for (const TargetResult& result : results)
    if (result.before_truth && result.after_truth)
      changes.push_back(result.after_truth->norm() - result.before_truth->norm());
  if (changes.size() < kEnoughTargets) return false;
  const auto n = static_cast<double>(changes.size());
  const double change = mean(changes);
  const double variance = (rms(changes) * rms(changes) - change * change) / (n - 1.0);
  return change > kSigmas * std::sqrt(std::max(0.0, variance));
}

std::optional<TrackerFigures> tracker_figures(const std::vector<TargetResult>& results) {
  TrackerFigures figures;
  double squares = 0.0, variances = 0.0;
  for (const TargetResult& result : results) {
    if (!result.not_judged.empty()) figures.not_judged.emplace_back(result.id, result.not_judged);
    if (!result.sigma_truth_m || !result.after_truth) continue;
    ++figures.judged;
    squares += result.after_truth->squaredNorm();
    variances += *result.sigma_truth_m * *result.sigma_truth_m;
  }
  if (figures.judged == 0 && figures.not_judged.empty()) return std::nullopt;
  const double n = static_cast<double>(std::max<std::size_t>(figures.judged, 1));
  figures.sigma = std::sqrt(variances / n);
  figures.after_net = std::sqrt(std::max(0.0, (squares - 2.0 * variances) / n));
  return figures;
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
  figures.made_worse = made_worse(results);
  figures.tracker = tracker_figures(results);
  return figures;
}

}  // namespace planar
