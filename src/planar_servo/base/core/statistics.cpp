#include "planar_servo/base/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace planar {
namespace {

void require_values(const std::vector<double>& values) {
  if (values.empty()) throw std::invalid_argument("statistics of an empty set");
}

}  // namespace

// Q_k+2(x) = Q_k(x) + (x/2)^(k/2) exp(-x/2) / Gamma(k/2 + 1), from Q_1 or Q_2 [Abramowitz and
// Stegun 1964, 26.4.8].
double chi_square_tail(double square, int degrees) {
  if (degrees < 1) throw std::invalid_argument("no degree of freedom");
  if (square <= 0.0) return 1.0;
  const double half = 0.5 * square;
  double k = degrees % 2 == 0 ? 2.0 : 1.0;
  double tail = degrees % 2 == 0 ? std::exp(-half) : std::erfc(std::sqrt(half));
  for (; k < degrees; k += 2.0)
    tail += std::exp(0.5 * k * std::log(half) - half - std::lgamma(0.5 * k + 1.0));
  return tail;
}

double binomial_tail(int k, int n, double p) {
  double tail = 0.0;
  for (int i = 0; i <= k; ++i)
    tail += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) +
                     i * std::log(p) + (n - i) * std::log1p(-p));
  return tail;
}

double mean(const std::vector<double>& values) {
  require_values(values);
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double rms(const std::vector<double>& values) {
  require_values(values);
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double standard_deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double quantile(std::vector<double> values, double fraction) {
  require_values(values);
  if (!(fraction >= 0.0 && fraction <= 1.0)) throw std::invalid_argument("fraction not in [0, 1]");
  const double position = fraction * static_cast<double>(values.size() - 1);
  const auto below = values.begin() + static_cast<std::ptrdiff_t>(position);
  std::nth_element(values.begin(), below, values.end());
  const auto above = below + 1 == values.end() ? below : std::min_element(below + 1, values.end());
  return *below + (position - std::floor(position)) * (*above - *below);
}

double median(std::vector<double> values) {
  return quantile(std::move(values), 0.5);
}

std::optional<std::pair<double, double>> quantile_interval(std::vector<double> values,
                                                           double fraction, double confidence) {
  require_values(values);
  if (!(fraction > 0.0 && fraction < 1.0)) throw std::invalid_argument("fraction not in (0, 1)");
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  // As many values lie below the quantile as heads fall in n throws of a coin that is so biased.
  const auto heads = [&](std::size_t count) {
    const auto all = static_cast<double>(n), k = static_cast<double>(count);
    return std::exp(std::lgamma(all + 1.0) - std::lgamma(k + 1.0) - std::lgamma(all - k + 1.0) +
                    k * std::log(fraction) + (all - k) * std::log1p(-fraction));
  };
  const double most = 0.5 * (1.0 - confidence);
  std::size_t low = 0, high = 0;
  for (double tail = heads(0); tail <= most && low < n; tail += heads(low)) ++low;
  for (double tail = heads(n); tail <= most && high < n; tail += heads(n - high)) ++high;
  if (low == 0 || high == 0) return std::nullopt;
  return std::pair(values[low - 1], values[n - high]);
}

std::optional<std::pair<double, double>> median_interval(std::vector<double> values,
                                                         double confidence) {
  return quantile_interval(std::move(values), 0.5, confidence);
}

double robust_sigma(std::vector<double> values) {
  const double centre = median(values);
  for (double& value : values) value = std::abs(value - centre);
  return kNormalPerMad * median(std::move(values));
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) throw std::invalid_argument("correlation of sets of different size");
  const double mean_a = mean(a), mean_b = mean(b);
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
    ab += (a[i] - mean_a) * (b[i] - mean_b);
  }
  return ab / std::sqrt(aa * bb);
}

Summary summarize(const std::vector<double>& values) {
  return {values.size(), mean(values), rms(values), quantile(values, 0.95),
          *std::max_element(values.begin(), values.end())};
}

}  // namespace planar
