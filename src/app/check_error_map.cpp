#include "app/check_error_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace planar {
namespace {

constexpr double kQuantile95 = 1.959964;  // of the normal distribution, two-sided

/// The noise of a pair per axis, metres: as its row states it, else `fallback`.
double pair_noise(const PairRow& pair, double fallback) {
  if (!pair.sigma_vision && !pair.sigma_tracker) return fallback;
  return std::hypot(pair.sigma_vision.value_or(0.0), pair.sigma_tracker.value_or(0.0));
}

/// How many of the two components of `miss` lie within the 95 % interval.
int covered_components(const Eigen::Vector2d& miss, double sigma) {
  return static_cast<int>((miss.array().abs() <= kQuantile95 * sigma).count());
}

bool is_wanted(const PairRow& pair, const std::vector<std::string>& plans) {
  if (plans.empty()) return pair.plan != "train";
  return std::find(plans.begin(), plans.end(), pair.plan) != plans.end();
}

}  // namespace

std::vector<PairRow> pairs_to_check(const std::vector<PairRow>& pairs,
                                    const std::vector<std::string>& plans) {
  std::vector<PairRow> wanted;
  for (const PairRow& pair : pairs)
    if (is_wanted(pair, plans)) wanted.push_back(pair);
  if (wanted.empty())
    throw InputError(fmt::format(
        "none of {} pairs is of plan {}", pairs.size(),
        plans.empty() ? "other than train" : fmt::format("{}", fmt::join(plans, ", "))));
  return wanted;
}

MapCheck check_error_map(const ErrorMap& map, const std::vector<PairRow>& pairs) {
  MapCheck check;
  std::vector<double> raw;
  std::vector<double> predicted;
  std::vector<double> missed;
  const double map_noise = noise_sigma(map);
  int covered = 0;
  bool has_sigma = true;
  for (const PairRow& pair : pairs) {
    const ErrorPrediction prediction = predict(map, pair.p_vision);
    const Eigen::Vector2d miss = pair.error() - prediction.error;
    raw.push_back(pair.error().norm());
    predicted.push_back(prediction.error.norm());
    missed.push_back(miss.norm());
    const double sigma = std::hypot(prediction.sigma, pair_noise(pair, map_noise));
    has_sigma = has_sigma && std::isfinite(sigma);
    covered += covered_components(miss, sigma);
    if (!prediction.inside) ++check.n_outside;
  }
  check.raw = summarize(raw);
  check.compensated = summarize(missed);
  check.a1 = 1.0 - check.compensated.mean / check.raw.mean;
  check.a2 = 1.0 - std::abs(check.raw.mean - mean(predicted)) / check.raw.mean;
  check.coverage_95 = has_sigma ? covered / (2.0 * static_cast<double>(pairs.size()))
                                : std::numeric_limits<double>::quiet_NaN();
  return check;
}

}  // namespace planar
