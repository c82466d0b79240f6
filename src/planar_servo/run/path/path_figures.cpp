#include "planar_servo/run/path/path_figures.h"

#include <algorithm>
#include <cmath>

namespace planar {
namespace {

std::optional<PathErrors> errors_of(std::vector<double> across_m,
                                    const std::vector<double>& lag_m) {
  if (across_m.empty()) return std::nullopt;
  for (double& length : across_m) length = std::abs(length);
  PathErrors errors;
  errors.across_m = summarize(across_m);
  errors.lag_mean_m = mean(lag_m);
  for (const double lag : lag_m) errors.lag_max_m = std::max(errors.lag_max_m, std::abs(lag));
  return errors;
}

}  // namespace

PathSpeedResult path_figures(const std::vector<PathLookRow>& looks) {
  PathSpeedResult result;
  std::vector<double> across, lag, across_truth, lag_truth;
  for (const PathLookRow& row : looks) {
    ++result.looks;
    if (row.look.measurement.ok()) {
      across.push_back(row.look.seen.across_m);
      lag.push_back(row.lag_m());
    }
    if (!row.truth) continue;
    across_truth.push_back(row.truth->across_m);
    lag_truth.push_back(*row.lag_truth_m());
  }
  result.own_view = errors_of(std::move(across), lag);
  result.truth = errors_of(std::move(across_truth), lag_truth);
  return result;
}

}  // namespace planar
