#include "planar_servo/error_map/judge/outlier_rule.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

constexpr double kFalseAlarms = 0.05;
constexpr double kLargestShare = 0.2;

}  // namespace

double residual_length(double share, double dof) {
  if (dof == kNormal) return std::sqrt(-2.0 * std::log(share));
  return std::sqrt(dof * (std::pow(share, -2.0 / dof) - 1.0));
}

double tail_dof(const std::vector<double>& lengths) {
  // With a = 2^(2 / dof) the squared ratio of the two lengths is (a^3 - 1) / (a - 1) = a^2 + a + 1.
  const double ratio = quantile(lengths, 1.0 - 0.125) / median(lengths);
  const double a = 0.5 * (std::sqrt(4.0 * ratio * ratio - 3.0) - 1.0);
  return a > 1.0 ? 2.0 / std::log2(a) : kNormal;
}

double outlier_sigmas(Eigen::Index sites, double dof) {
  return residual_length(kFalseAlarms / static_cast<double>(sites), dof);
}

void require_few(const Outliers& dropped, Eigen::Index sites) {
  if (static_cast<double>(dropped.size()) <= kLargestShare * static_cast<double>(sites)) return;
  throw InputError(fmt::format(
      "{} of {} pairs disagree with the others, but at most {:.0f} % may; are the positions of "
      "vision and tracker paired rightly?",
      dropped.size(), sites, 100.0 * kLargestShare));
}

std::vector<Eigen::Index> sites_without(const Outliers& dropped, Eigen::Index count) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (dropped.count(i) == 0) kept.push_back(i);
  }
  return kept;
}

std::vector<Outlier> values_of(const Outliers& dropped) {
  std::vector<Outlier> outliers;
  for (const auto& [site, outlier] : dropped) outliers.push_back(outlier);
  return outliers;
}

}  // namespace planar
