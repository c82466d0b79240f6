#include "error_map/outlier_rule.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"

namespace planar {
namespace {

constexpr double kFalseAlarms = 0.05;
constexpr double kLargestShare = 0.2;

}  // namespace

double normal_length(double share) {
  return std::sqrt(-2.0 * std::log(share));
}

double outlier_sigmas(Eigen::Index sites) {
  return normal_length(kFalseAlarms / static_cast<double>(sites));
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
