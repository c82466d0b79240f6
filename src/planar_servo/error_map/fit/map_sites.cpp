#include "planar_servo/error_map/fit/map_sites.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/maps/tail_basis.h"

namespace planar {
namespace {

/// Samples in one cell of a grid with this pitch count as one position. It is far below what vision
/// resolves, and centres that are closer would only worsen the condition of the equations.
constexpr double kSamePosition = 0.1 * kMicrometre;

constexpr Eigen::Index kFewestSites = 3;

void require_finite(const std::vector<ErrorSample>& samples) {
  Faults faults;
  for (const ErrorSample& sample : samples) {
    if (sample.p_vision.allFinite() && sample.error.allFinite() &&
        std::isfinite(sample.phi.value_or(0.0)))
      continue;
    faults.add(
        fmt::format("pair {}: position, error or direction is not a finite number; remove the pair",
                    sample.id));
  }
  faults.throw_if_any();
}

double stated_sigma_of(const std::vector<ErrorSample>& samples) {
  double sum = 0.0;
  for (const ErrorSample& sample : samples) {
    if (!(sample.sigma > 0.0)) return 0.0;
    sum += sample.sigma * sample.sigma;
  }
  return std::sqrt(sum / static_cast<double>(samples.size()));
}

Eigen::Matrix2Xd mean_directions(const std::vector<ErrorSample>& samples,
                                 const std::vector<std::vector<std::size_t>>& groups) {
  const auto names_phi = [](const ErrorSample& sample) { return sample.phi.has_value(); };
  if (!std::all_of(samples.begin(), samples.end(), names_phi)) return {};
  Eigen::Matrix2Xd means = Eigen::Matrix2Xd::Zero(2, static_cast<Eigen::Index>(groups.size()));
  for (std::size_t site = 0; site < groups.size(); ++site) {
    for (const std::size_t i : groups[site]) {
      const double phi = *samples[i].phi;
      means.col(static_cast<Eigen::Index>(site)) +=
          Eigen::Vector2d(std::cos(phi), std::sin(phi)) / static_cast<double>(groups[site].size());
    }
  }
  return means;
}

std::vector<std::vector<std::size_t>> group_by_position(const std::vector<ErrorSample>& samples) {
  std::vector<std::vector<std::size_t>> groups;
  std::map<std::pair<double, double>, std::size_t> group_of_cell;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector2d cell = (samples[i].p_vision / kSamePosition).array().round();
    const auto [found, is_new] = group_of_cell.try_emplace({cell.x(), cell.y()}, groups.size());
    if (is_new) groups.emplace_back();
    groups[found->second].push_back(i);
  }
  return groups;
}

}  // namespace

MapSites MapSites::subset(const std::vector<Eigen::Index>& kept) const {
  MapSites sites{positions(Eigen::all, kept),
                 errors(Eigen::all, kept),
                 counts(kept),
                 scatter(kept),
                 {},
                 stated_sigma,
                 {}};
  if (has_directions()) sites.directions = directions(Eigen::all, kept);
  for (const Eigen::Index i : kept) sites.samples.push_back(samples[static_cast<std::size_t>(i)]);
  return sites;
}

MapSites MapSites::every(Eigen::Index stride) const {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < size(); i += stride) kept.push_back(i);
  return subset(kept);
}

Eigen::Vector2d MapSites::direction(Eigen::Index site) const {
  return has_directions() ? Eigen::Vector2d(directions.col(site)) : TailBasis::unknown_direction();
}

double MapSites::sample_rms(const Eigen::Matrix2Xd& means) const {
  const double sum = means.colwise().squaredNorm().dot(counts) + scatter.sum();
  return std::sqrt(sum / counts.sum());
}

MapSites merge_samples(const std::vector<ErrorSample>& samples) {
  require_finite(samples);
  MapSites sites;
  sites.samples = group_by_position(samples);
  sites.stated_sigma = stated_sigma_of(samples);
  const auto count = static_cast<Eigen::Index>(sites.samples.size());
  if (count < kFewestSites) {
    throw InputError(fmt::format(
        "{} pairs have {} distinct positions; a map needs at least {} distinct positions",
        samples.size(), count, kFewestSites));
  }
  sites.directions = mean_directions(samples, sites.samples);
  sites.positions.setZero(2, count);
  sites.errors.setZero(2, count);
  sites.counts.setZero(count);
  sites.scatter.setZero(count);
  for (Eigen::Index site = 0; site < count; ++site) {
    const auto& merged = sites.samples[static_cast<std::size_t>(site)];
    sites.counts[site] = static_cast<double>(merged.size());
    for (const std::size_t i : merged) {
      sites.positions.col(site) += samples[i].p_vision / sites.counts[site];
      sites.errors.col(site) += samples[i].error / sites.counts[site];
    }
    for (const std::size_t i : merged) {
      sites.scatter[site] += (samples[i].error - sites.errors.col(site)).squaredNorm();
    }
  }
  return sites;
}

}  // namespace planar
