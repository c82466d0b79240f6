#pragma once

#include <cstddef>
#include <vector>

namespace planar {

/// Figures of a set of non-negative deviations (or of any numbers). Empty sets are refused.
struct Summary {
  std::size_t n{0};
  double mean{0.0};
  double rms{0.0};
  double p95{0.0};
  double max{0.0};
};

/// All of these throw std::invalid_argument for an empty set.
double mean(const std::vector<double>& values);
double rms(const std::vector<double>& values);
double median(std::vector<double> values);

/// Linear interpolation between order statistics; `fraction` in [0, 1].
double quantile(std::vector<double> values, double fraction);

/// Standard deviation of normal data over their median absolute deviation from the median.
constexpr double kNormalPerMad = 1.4826;

/// kNormalPerMad * median |v - median v|: the standard deviation of normal data, deaf to outliers.
double robust_sigma(const std::vector<double>& values);

/// Pearson's correlation of two sets of the same size; NaN when one of them does not vary.
double correlation(const std::vector<double>& a, const std::vector<double>& b);

Summary summarize(const std::vector<double>& values);

}  // namespace planar
