#include "planar_servo/error_map/judge/place_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

using SamplesOfPlace = std::vector<std::size_t>;

constexpr double kWidestPlace = 0.1;

/// In a smaller place nobody knows which sample is wrong.
constexpr std::size_t kFewestToCompare = 3;

/// With fewer deviations their usual length is not known.
constexpr std::size_t kFewestDeviations = 30;

double width_of(const std::vector<ErrorSample>& samples, const SamplesOfPlace& of) {
  Eigen::AlignedBox2d box;
  for (const std::size_t i : of) box.extend(samples[i].p_vision);
  return box.diagonal().norm();
}

double width_of(const Eigen::Matrix2Xd& positions) {
  return (positions.rowwise().maxCoeff() - positions.rowwise().minCoeff()).norm();
}

/// Returns how far each sample's error is from the mean of the others of its place, divided so that
/// independent samples deviate like their noise, metres.
std::vector<double> deviations(const std::vector<ErrorSample>& samples, const SamplesOfPlace& of) {
  const auto count = static_cast<double>(of.size());
  Eigen::Vector2d mean(0.0, 0.0);
  for (const std::size_t i : of) mean += samples[i].error / count;
  std::vector<double> lengths;
  for (const std::size_t i : of)
    lengths.push_back((samples[i].error - mean).norm() * std::sqrt(count / (count - 1.0)));
  return lengths;
}

/// Returns the largest deviation with which a sample is kept.
double largest_usual(const std::vector<double>& all) {
  if (!(median(all) > 0.0)) return std::numeric_limits<double>::infinity();
  const double dof = tail_dof(all);
  const double scale = median(all) / residual_length(0.5, dof);
  const auto count = static_cast<Eigen::Index>(all.size());
  return std::max(kSmallestOutlier, outlier_sigmas(count, dof) * scale);
}

/// Drops the samples of one place that deviate, the worst first.
void drop_unlike(const std::vector<ErrorSample>& samples, SamplesOfPlace of, double limit,
                 Outliers& dropped) {
  while (of.size() >= kFewestToCompare) {
    const std::vector<double> lengths = deviations(samples, of);
    const auto worst = std::max_element(lengths.begin(), lengths.end());
    if (*worst <= limit) return;
    const auto at = of.begin() + (worst - lengths.begin());
    const auto sample = static_cast<Eigen::Index>(*at);
    dropped[sample] = {sample, *worst, limit};
    of.erase(at);
  }
}

}  // namespace

void require_narrow_places(const std::vector<ErrorSample>& samples, const MapSites& sites) {
  const double widest = kWidestPlace * width_of(sites.positions);
  Faults faults;
  for (const SamplesOfPlace& of : sites.samples) {
    const double width = width_of(samples, of);
    if (width <= widest || samples[of.front()].place.empty()) continue;
    faults.add(fmt::format(
        "place '{}': its {} pairs lie up to {:.1f} mm apart, where {:.1f} mm is allowed, a tenth "
        "of the field; name the places of single positions, or remove the column place",
        samples[of.front()].place, of.size(), width / kMillimetre, widest / kMillimetre));
  }
  faults.throw_if_any();
}

Outliers samples_unlike_their_place(const std::vector<ErrorSample>& samples,
                                    const MapSites& sites) {
  std::vector<double> all;
  for (const SamplesOfPlace& of : sites.samples) {
    if (of.size() < kFewestToCompare) continue;
    const std::vector<double> here = deviations(samples, of);
    all.insert(all.end(), here.begin(), here.end());
  }
  Outliers dropped;
  if (all.size() < kFewestDeviations) return dropped;
  const double limit = largest_usual(all);
  for (const SamplesOfPlace& of : sites.samples) drop_unlike(samples, of, limit, dropped);
  require_few(dropped, static_cast<Eigen::Index>(samples.size()));
  return dropped;
}

}  // namespace planar
