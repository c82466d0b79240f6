#include "planar_servo/error_map/fit_error_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/fit/found_places.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/fit/sparse_fit.h"
#include "planar_servo/error_map/judge/cross_validation.h"
#include "planar_servo/error_map/judge/outliers.h"
#include "planar_servo/error_map/judge/place_check.h"
#include "planar_servo/error_map/judge/unit_check.h"

namespace planar {
namespace {

/// Samples that lie in groups must be so many more than the groups, as a share of all.
constexpr double kLeastRepeats = 0.2;

/// The samples of a group share a place if they have more than this share of their noise's variance
/// in common, or if without the whole group they are missed by so many times the leave-one-out
/// error. Else they are as good as apart, and averaging them would blur the map.
constexpr double kClearShare = 0.2;
constexpr double kClearMiss = 1.25;

MapResult result_of(ErrorMap map, const MapSites& used, const Eigen::Matrix2Xd& residuals) {
  MapResult result;
  result.map = std::move(map);
  result.n_used = static_cast<std::size_t>(used.counts.sum());
  result.n_places = static_cast<std::size_t>(used.size());
  result.raw_rms = used.sample_rms(used.errors);
  result.loo_rms = used.sample_rms(residuals);
  result.idw_loo_rms = used.size() <= kMostDense
                           ? used.sample_rms(leave_one_out_residuals(idw_map(used)))
                           : std::numeric_limits<double>::quiet_NaN();
  result.noise_sigma = noise_sigma(result.map);
  const CrossValidation validation = cross_validate(result.map, used);
  result.blocked = validation.rms;
  result.gap = validation.gap;
  result.worth_using = is_worth_using(used, residuals);
  result.cell = diagnose_cell(used);
  return result;
}

std::vector<RejectedSample> rejected_samples(const std::vector<Outlier>& outliers,
                                             const MapSites& sites,
                                             const std::vector<ErrorSample>& samples) {
  std::vector<RejectedSample> rejected;
  for (const Outlier& outlier : outliers) {
    const std::string reason =
        fmt::format("{:.4f} mm from what the other pairs predict there, where {:.4f} mm is allowed",
                    outlier.residual / kMillimetre, outlier.limit / kMillimetre);
    for (const std::size_t i : sites.samples[static_cast<std::size_t>(outlier.site)]) {
      rejected.push_back({i, samples[i].id, outlier.residual, reason});
    }
  }
  return rejected;
}

MapResult fit_tuned(const MapSites& sites, const std::vector<RbfFamily>& families,
                    const std::vector<ErrorSample>& samples) {
  RobustFit robust = fit_without_outliers(sites, families);
  MapResult result = result_of(std::move(robust.fit.map), sites.subset(robust.kept),
                               robust.fit.left_out.residuals);
  result.rejected = rejected_samples(robust.outliers, sites, samples);
  return result;
}

MapResult fit_many(const MapSites& sites, const std::vector<ErrorSample>& samples,
                   const Progress& progress) {
  SparseFit fit = fit_sparse(sites, progress);
  tell(progress, "judging the map", 0, 1);
  MapResult result = result_of(std::move(fit.map), sites.subset(fit.kept), fit.residuals);
  result.rejected = rejected_samples(fit.outliers, sites, samples);
  return result;
}

void require_dense(const MapSites& sites, MapMethod method) {
  if (sites.size() <= kMostDense) return;
  throw InputError(
      fmt::format("the pairs have {} distinct positions; the method {} takes at most {}; leave "
                  "some out, or use auto",
                  sites.size(), name_in(kMapMethods, method), kMostDense));
}

MapResult fit_by_hand(const MapSites& sites, double width) {
  if (!(std::isfinite(width) && width > 0.0)) {
    throw InputError(
        fmt::format("the map's width is {} mm; it must be a positive number", width / kMillimetre));
  }
  RbfFit fit = fit_hand_width(sites, width);
  return result_of(std::move(fit.map), sites, fit.left_out.residuals);
}

MapResult fit_to(const MapSites& sites, const MapProblem& problem, const Progress& progress) {
  if (problem.method != MapMethod::kAuto) require_dense(sites, problem.method);
  switch (problem.method) {
    case MapMethod::kIdw: {
      const IdwMap map = idw_map(sites);
      return result_of(map, sites, leave_one_out_residuals(map));
    }
    case MapMethod::kHandWidth:
      return fit_by_hand(sites, problem.hand_width);
    case MapMethod::kRbf:
      return fit_tuned(sites, {kOneWidth}, problem.samples);
    case MapMethod::kAuto:
      break;
  }
  if (sites.size() > kMostDense) return fit_many(sites, problem.samples, progress);
  return fit_tuned(sites, {kManyScales, kSmooth}, problem.samples);
}

double count_of_repeats(const MapSites& sites) {
  return sites.counts.sum() - static_cast<double>(sites.size());
}

/// Returns the share of the noise's variance that the samples of a site have in common, if
/// `site_noise2` is that of their means.
double place_share(const MapSites& sites, double site_noise2) {
  const double reading2 = sites.scatter.sum() / (2.0 * count_of_repeats(sites));
  const double place2 = std::max(0.0, site_noise2 - reading2 * sites.counts.cwiseInverse().mean());
  return place2 > 0.0 ? place2 / (place2 + reading2) : 0.0;
}

bool is_tuned(MapMethod method) {
  return method == MapMethod::kAuto || method == MapMethod::kRbf;
}

/// Fits twice where the method finds the noise: at first as if all samples of a site were wrong
/// alike, which tells the noise of their means, and then with the share that follows from it.
MapResult fit_to_places(MapSites sites, const MapProblem& problem, const Progress& progress) {
  if (!is_tuned(problem.method) || !(count_of_repeats(sites) > 0.0))
    return fit_to(sites, problem, progress);
  MapSites alike = sites;
  alike.place_share = 1.0;
  alike.stated_sigma *= std::sqrt(sites.counts.cwiseInverse().mean());
  const double site_noise = fit_to(alike, problem, progress).noise_sigma;
  sites.place_share = place_share(sites, site_noise * site_noise);
  MapResult result = fit_to(sites, problem, progress);
  result.place_share = sites.place_share;
  return result;
}

/// Fits to the samples that agree with the others of their place.
MapResult fit_to_agreeing(const MapProblem& problem, const Progress& progress) {
  const Outliers unlike =
      samples_unlike_their_place(problem.samples, merge_samples(problem.samples));
  std::vector<bool> used(problem.samples.size(), true);
  std::vector<RejectedSample> rejected;
  for (const auto& [index, outlier] : unlike) {
    const auto i = static_cast<std::size_t>(index);
    used[i] = false;
    rejected.push_back(
        {i, problem.samples[i].id, outlier.residual,
         fmt::format("{:.4f} mm from the other pairs of its place, where {:.4f} mm is allowed",
                     outlier.residual / kMillimetre, outlier.limit / kMillimetre)});
  }
  MapResult result = fit_to_places(merge_samples(problem.samples, used), problem, progress);
  result.rejected.insert(result.rejected.begin(), rejected.begin(), rejected.end());
  return result;
}

/// Fits to the places that the positions show; empty if they show none.
std::optional<MapResult> fit_to_found_places(const MapProblem& problem, const MapSites& sites,
                                             const Progress& progress) {
  if (!is_tuned(problem.method)) return {};
  const MapProblem with_places{with_found_places(problem.samples, sites), problem.method,
                               problem.hand_width};
  const MapSites places = merge_samples(with_places.samples);
  if (count_of_repeats(places) < kLeastRepeats * static_cast<double>(problem.samples.size()))
    return {};
  MapResult result = fit_to_agreeing(with_places, progress);
  result.places = PlaceSource::kFound;
  return result;
}

}  // namespace

MapResult fit_error_map(const MapProblem& problem, const Progress& progress) {
  const MapSites sites = merge_samples(problem.samples);
  require_one_unit(sites.positions, sites.positions - sites.errors);
  require_live_tracker(problem.samples);
  if (names_places(problem.samples)) {
    require_narrow_places(problem.samples, sites);
    MapResult result = fit_to_agreeing(problem, progress);
    result.places = PlaceSource::kNamed;
    return result;
  }
  std::optional<MapResult> together = fit_to_found_places(problem, sites, progress);
  if (together && together->place_share > kClearShare) return *std::move(together);
  MapResult apart = fit_to(sites, problem, progress);
  if (together && together->loo_rms > kClearMiss * apart.loo_rms) return *std::move(together);
  return apart;
}

}  // namespace planar
