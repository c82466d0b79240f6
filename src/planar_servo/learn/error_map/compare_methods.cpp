#include "planar_servo/learn/error_map/compare_methods.h"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/learn/error_map/fit/map_sites.h"
#include "planar_servo/learn/error_map/fit/rbf_fit.h"

namespace planar {
namespace {

MapSites sites_used(const MapProblem& problem, const MapResult& result) {
  std::vector<bool> used(problem.samples.size(), true);
  for (const RejectedSample& sample : result.rejected) used[sample.index] = false;
  if (result.places != PlaceSource::kFound) return merge_samples(problem.samples, used);
  const MapSites by_position = merge_samples(problem.samples);
  return merge_samples(with_found_places(problem.samples, by_position), used);
}

std::string name_of(MapMethod method, double width) {
  const std::string name = name_in(kMapMethods, method);
  return method == MapMethod::kHandWidth ? fmt::format("{}:{:g}", name, mm(width)) : name;
}

RbfFit rbf_fit(MapMethod method, double width, const MapSites& sites) {
  if (method == MapMethod::kHandWidth) return fit_hand_width(sites, width);
  if (method == MapMethod::kRbf) return fit_rbf(sites, tune(sites, kOneWidth));
  return fit_rbf(sites, best_of(tune(sites, {kManyScales, kSmooth})));
}

MethodFigures figures_of(MapMethod method, double width, const MapSites& sites) {
  const std::string name = name_of(method, width);
  if (method == MapMethod::kIdw) {
    const IdwMap map = idw_map(sites);
    return {name, sites.sample_rms(leave_one_out_residuals(map)), cross_validate(map, sites).rms};
  }
  try {
    RbfFit fit = rbf_fit(method, width, sites);
    const double loo_rms = sites.sample_rms(fit.left_out.residuals);
    return {name, loo_rms, cross_validate(std::move(fit.map), sites).rms};
  } catch (const WorkError&) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    return {name, kNan, {kNan, kNan, kNan}};
  }
}

}  // namespace

std::vector<MethodFigures> compare_methods(const MapProblem& problem, const MapResult& result,
                                           const Progress& progress) {
  MapSites sites = sites_used(problem, result);
  if (result.place_share > 0.0) sites.place_share = result.place_share;
  const RmsEstimate raw = estimate_rms(sites, sites.errors, spatial_blocks(sites.positions));
  std::vector<MethodFigures> rows{{"raw", raw.value, raw}};
  constexpr std::array kMethods{MapMethod::kIdw, MapMethod::kHandWidth, MapMethod::kRbf,
                                MapMethod::kAuto};
  for (const MapMethod method : kMethods) {
    tell(progress, "comparing methods", rows.size() - 1, kMethods.size());
    const double width = problem.method == MapMethod::kHandWidth ? problem.hand_width : kPaperWidth;
    if (method == problem.method)
      rows.push_back({name_of(method, width), result.loo_rms, result.blocked});
    else if (sites.size() <= kMostDense)
      rows.push_back(figures_of(method, width, sites));
  }
  return rows;
}

}  // namespace planar
