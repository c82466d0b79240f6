#include "planar_servo/calibration/readings/robust_errors.h"

#include <algorithm>
#include <cmath>

namespace planar {
namespace {

/// Returns by how much the others miss an error.
Eigen::RowVector2d miss_of(const SmoothRemainders& left, Eigen::Index i) {
  return left.weighted.row(i) / left.diagonal[i];
}

/// Returns the deviation of miss_of() per axis if the error is no outlier.
double deviation_of_miss(const Explanation& by, const SmoothRemainders& left, Eigen::Index i) {
  const bool is_out = by.outliers[static_cast<std::size_t>(i)];
  const double variance = 1.0 / left.diagonal[i] - (is_out ? SmoothErrors::kNoWeight - 1.0 : 0.0);
  return by.fit.noise * std::sqrt(std::max(1.0, variance));
}

/// Returns which errors are outliers, as the others predict them.
SmoothErrors::Outliers outliers_beside(const SmoothErrors& errors, const Explanation& by,
                                       const SmoothRemainders& left) {
  constexpr long kLargestShare = 5;
  SmoothErrors::Outliers outliers = by.outliers;
  for (Eigen::Index i = 0; i < errors.size(); ++i)
    outliers[static_cast<std::size_t>(i)] =
        SmoothErrors::is_outlier(miss_of(left, i).norm(), deviation_of_miss(by, left, i));
  const bool few = kLargestShare * std::count(outliers.begin(), outliers.end(), true) <=
                   static_cast<long>(errors.size());
  return few ? outliers : by.outliers;
}

/// Alternates between naming outliers and tuning until both agree.
void leave_out_outliers(const SmoothErrors& errors, Explanation& found) {
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds; ++round) {
    const SmoothRemainders left = errors.remainders(found.fit.tuning, found.outliers, found.step);
    SmoothErrors::Outliers outliers = outliers_beside(errors, found, left);
    if (outliers == found.outliers) return;
    found.outliers = std::move(outliers);
    found.fit = errors.tuned(found.fit.tuning, found.outliers, found.step);
  }
}

}  // namespace

SmoothErrors::Outliers no_outliers(const SmoothErrors& errors) {
  return SmoothErrors::Outliers(static_cast<std::size_t>(errors.size()), false);
}

Explanation without_step(const SmoothErrors& errors) {
  Explanation found;
  found.outliers = no_outliers(errors);
  found.fit = errors.tuned({}, found.outliers, {});
  leave_out_outliers(errors, found);
  return found;
}

Explanation with_step(const SmoothErrors& errors, const StepShape& step, const Explanation& start) {
  Explanation found{start.fit, no_outliers(errors), step};
  found.outliers =
      outliers_beside(errors, found, errors.remainders(found.fit.tuning, found.outliers, step));
  found.fit = errors.tuned(found.fit.tuning, found.outliers, step);
  leave_out_outliers(errors, found);
  return found;
}

Eigen::MatrixX2d with_outliers_moved(const SmoothErrors& errors, const Explanation& by) {
  constexpr double kMostDeviations = 5.0;
  const SmoothRemainders left = errors.remainders(by.fit.tuning, by.outliers, by.step);
  Eigen::MatrixX2d moved = errors.errors();
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    if (!by.outliers[static_cast<std::size_t>(i)]) continue;
    const Eigen::RowVector2d miss = miss_of(left, i);
    const double most = kMostDeviations * deviation_of_miss(by, left, i);
    moved.row(i) -= std::max(0.0, 1.0 - most / miss.norm()) * miss;
  }
  return moved;
}

}  // namespace planar
