#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace planar {

/// The chance at which one question put to sound measurements is answered with a doubt.
constexpr double kFalseAlarm = 1e-3;

/// Returns the chance that the squares of `degrees` independent standard normal numbers add up to
/// more than `square`. Throws std::invalid_argument unless there is at least one degree of freedom.
double chi_square_tail(double square, int degrees);

/// Returns the chance that at most `k` of `n` independent draws succeed, each with chance `p`.
double binomial_tail(int k, int n, double p);

/// Summarizes a set of deviations or of any other numbers.
struct Summary {
  std::size_t n{0};
  double mean{0.0};
  double rms{0.0};
  double p95{0.0};
  double max{0.0};
};

/// These and all functions below throw std::invalid_argument for an empty set.
double mean(const std::vector<double>& values);
double rms(const std::vector<double>& values);
double median(std::vector<double> values);
/// Returns the standard deviation over n - 1; NaN for one value.
double standard_deviation(const std::vector<double>& values);

/// Interpolates linearly between order statistics; `fraction` lies in [0, 1].
double quantile(std::vector<double> values, double fraction);

/// Returns two of the values between which this quantile of what they are drawn from lies with at
/// least this confidence, whatever its distribution [Conover 1999, 3.2]: the innermost order
/// statistics that do. Empty when even the smallest and the largest value do not. `fraction` lies
/// in (0, 1).
std::optional<std::pair<double, double>> quantile_interval(std::vector<double> values,
                                                           double fraction, double confidence);

/// Returns quantile_interval() of the median.
std::optional<std::pair<double, double>> median_interval(std::vector<double> values,
                                                         double confidence);

/// The standard deviation of normal data divided by their median absolute deviation.
constexpr double kNormalPerMad = 1.4826;

/// Returns kNormalPerMad * median |v - median v|: the standard deviation of normal data, hardly
/// affected by outliers.
double robust_sigma(std::vector<double> values);

/// Returns Pearson's correlation of two sets of the same size, or NaN when one of them does not
/// vary.
double correlation(const std::vector<double>& a, const std::vector<double>& b);

Summary summarize(const std::vector<double>& values);

}  // namespace planar
