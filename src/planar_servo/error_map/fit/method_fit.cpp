#include "planar_servo/error_map/fit/method_fit.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/fit/rbf_families.h"
#include "planar_servo/error_map/fit/sparse_fit.h"
#include "planar_servo/error_map/judge/outliers.h"

namespace planar {
namespace {

Eigen::VectorXd sigmas_of(const RbfFit& fit) {
  return fit.map.parameters().signal_sigma * fit.left_out.unit_sigmas;
}

MethodFit fit_tuned(const MapSites& sites, const std::vector<RbfFamily>& families) {
  RobustFit robust = fit_without_outliers(sites, families);
  Eigen::VectorXd sigmas = sigmas_of(robust.fit);
  return {std::move(robust.fit.map), std::move(robust.kept), std::move(robust.outliers),
          std::move(robust.fit.left_out.residuals), std::move(sigmas)};
}

MethodFit fit_many(const MapSites& sites, const Progress& progress) {
  SparseFit fit = fit_sparse(sites, progress);
  return {std::move(fit.map), std::move(fit.kept), std::move(fit.outliers),
          std::move(fit.residuals), std::move(fit.sigmas)};
}

void require_dense(const MapSites& sites, MapMethod method) {
  if (sites.size() <= kMostDense) return;
  throw InputError(
      fmt::format("the pairs have {} distinct positions; the method {} takes at most {}; leave "
                  "some out, or use auto",
                  sites.size(), name_in(kMapMethods, method), kMostDense));
}

MethodFit fit_weighted(const MapSites& sites) {
  const IdwMap map = idw_map(sites);
  Eigen::Matrix2Xd residuals = leave_one_out_residuals(map);
  const double sigma = std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.size()));
  return {map,
          sites_without({}, sites.size()),
          {},
          std::move(residuals),
          Eigen::VectorXd::Constant(sites.size(), sigma)};
}

MethodFit fit_by_hand(const MapSites& sites, double width) {
  if (!(std::isfinite(width) && width > 0.0)) {
    throw InputError(
        fmt::format("the map's width is {} mm; it must be a positive number", width / kMillimetre));
  }
  RbfFit fit = fit_hand_width(sites, width);
  Eigen::VectorXd sigmas = sigmas_of(fit);
  return {std::move(fit.map),
          sites_without({}, sites.size()),
          {},
          std::move(fit.left_out.residuals),
          std::move(sigmas)};
}

}  // namespace

MethodFit fit_by_method(const MapSites& sites, const MapProblem& problem,
                        const Progress& progress) {
  if (problem.method != MapMethod::kAuto) require_dense(sites, problem.method);
  switch (problem.method) {
    case MapMethod::kIdw:
      return fit_weighted(sites);
    case MapMethod::kHandWidth:
      return fit_by_hand(sites, problem.hand_width);
    case MapMethod::kRbf:
      return fit_tuned(sites, {kOneWidth});
    case MapMethod::kAuto:
      break;
  }
  if (sites.size() > kMostDense) return fit_many(sites, progress);
  return fit_tuned(sites, {kManyScales, kSmooth});
}

}  // namespace planar
