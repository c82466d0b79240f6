#include "planar_servo/error_map/fit_error_map.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/fit/sparse_fit.h"
#include "planar_servo/error_map/judge/cross_validation.h"
#include "planar_servo/error_map/judge/outliers.h"
#include "planar_servo/error_map/judge/unit_check.h"

namespace planar {
namespace {

MapResult result_of(ErrorMap map, const MapSites& used, const Eigen::Matrix2Xd& residuals) {
  MapResult result;
  result.map = std::move(map);
  result.n_used = static_cast<std::size_t>(used.counts.sum());
  result.raw_rms = used.sample_rms(used.errors);
  result.loo_rms = used.sample_rms(residuals);
  result.idw_loo_rms = used.size() <= kMostDense
                           ? used.sample_rms(leave_one_out_residuals(idw_map(used)))
                           : std::numeric_limits<double>::quiet_NaN();
  result.noise_sigma = noise_sigma(result.map);
  const CrossValidation validation = cross_validate(result.map, used);
  result.blocked = validation.rms;
  result.worth_using = validation.worth_using;
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

}  // namespace

MapResult fit_error_map(const MapProblem& problem, const Progress& progress) {
  const MapSites sites = merge_samples(problem.samples);
  require_one_unit(sites.positions, sites.positions - sites.errors);
  require_live_tracker(problem.samples);
  switch (problem.method) {
    case MapMethod::kIdw: {
      require_dense(sites, problem.method);
      const IdwMap map = idw_map(sites);
      return result_of(map, sites, leave_one_out_residuals(map));
    }
    case MapMethod::kHandWidth:
      require_dense(sites, problem.method);
      return fit_by_hand(sites, problem.hand_width);
    case MapMethod::kRbf:
      require_dense(sites, problem.method);
      return fit_tuned(sites, {kOneWidth}, problem.samples);
    case MapMethod::kAuto:
      break;
  }
  if (sites.size() > kMostDense) return fit_many(sites, problem.samples, progress);
  return fit_tuned(sites, {kManyScales, kSmooth}, problem.samples);
}

}  // namespace planar
