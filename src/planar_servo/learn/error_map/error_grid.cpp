#include "planar_servo/learn/error_map/error_grid.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kFirstCells = 16.0;  ///< across the region, before the grid is refined
constexpr int kPlacesAcross = 4;      ///< by which each cell is checked

Eigen::Vector2d seen_from(const ErrorField& seen, const Eigen::Vector2d& p) {
  constexpr int kMostRounds = 50;
  constexpr double kNear = 1e-10;
  Eigen::Vector2d s = p;
  for (int i = 0; i < kMostRounds; ++i) {
    Eigen::Vector2d next = p + seen.error(s);
    if ((next - s).norm() < kNear) return next;
    s = next;
  }
  throw WorkError(
      {fmt::format("the error changes so fast near ({:.1f}, {:.1f}) mm that the place seen there "
                   "cannot be found",
                   mm(p.x()), mm(p.y())),
       "export it by places as seen: grid-csv or numpy", "", Cause::kInsufficient});
}

/// Returns the step with two digits in millimetres, and not more than it was.
double neat(double step) {
  const double unit = std::pow(10.0, std::floor(std::log10(mm(step))) - 1.0);
  return std::floor(mm(step) / unit + 1e-9) * unit * kMillimetre;
}

Eigen::AlignedBox2d box_of(const ValidRegion& region) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& corner : region.hull) box.extend(corner);
  if (box.isEmpty()) throw InputError("the map is valid nowhere: its hull has no corner");
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(region.margin);
  return {box.min() - margin, box.max() + margin};
}

/// Returns a grid over the region whose nodes are at multiples of the step, without values.
ErrorGrid empty_grid(const ValidRegion& region, double step) {
  const Eigen::AlignedBox2d box = box_of(region);
  const Eigen::Array2d first = (box.min().array() / step).floor();
  const Eigen::Array2d cells = ((box.max().array() / step).ceil() - first).max(1.0);
  if (const double nodes = (cells + 1.0).prod(); !(nodes <= static_cast<double>(kMostNodes)))
    throw InputError(
        {fmt::format("a grid of {:.3g} mm over its valid region has {:.3g} nodes", mm(step), nodes),
         fmt::format(
             "at most {} are written; name a larger step, or fit a smoother map by --method "
             "auto",
             kMostNodes)});
  ErrorGrid grid;
  grid.origin = first * step;
  grid.step = step;
  grid.columns = static_cast<Eigen::Index>(cells.x()) + 1;
  grid.rows = static_cast<Eigen::Index>(cells.y()) + 1;
  return grid;
}

ErrorGrid sampled(const ErrorField& field, double step) {
  ErrorGrid grid = empty_grid(field.region, step);
  ValidRegion sampled_region = field.region;
  sampled_region.margin += 1.5 * step;  // beyond a cell's diagonal
  grid.errors.resize(2, grid.nodes());
  grid.sigmas.resize(grid.nodes());
  grid.inside.resize(grid.nodes());
  for (Eigen::Index i = 0; i < grid.nodes(); ++i) {
    const ErrorPrediction found = field.predict(sampled_region.nearest(grid.node(i)));
    grid.errors.col(i) = found.error;
    grid.sigmas[i] = found.sigma;
    grid.inside[i] = found.inside && field.region.contains(grid.node(i));
  }
  if (!grid.errors.allFinite()) throw InputError("the map predicts errors that are not finite");
  return grid;
}

/// Returns the deviation by which a cell is judged.
double sigma_in_cell(const ErrorField& field, const ErrorGrid& grid, Eigen::Index i) {
  const double least = std::min({grid.sigmas[i], grid.sigmas[i + 1], grid.sigmas[i + grid.columns],
                                 grid.sigmas[i + grid.columns + 1]});
  return std::isfinite(least) ? least : field.sigma_if_unstated;
}

void judge_cell(const ErrorField& field, Eigen::Index i, SampledError& sampled) {
  const ErrorGrid& grid = sampled.grid;
  const double sigma = sigma_in_cell(field, grid, i);
  for (int k = 1; k < kPlacesAcross * kPlacesAcross; ++k) {
    const Eigen::Vector2d share =
        Eigen::Vector2d(k % kPlacesAcross, k / kPlacesAcross) / static_cast<double>(kPlacesAcross);
    const Eigen::Vector2d p = grid.node(i) + grid.step * share;
    if (!field.region.contains(p)) continue;
    const double miss = (grid.error_in_cell(i, share) - field.error(p)).cwiseAbs().maxCoeff();
    sampled.interpolation_max = std::max(sampled.interpolation_max, miss);
    sampled.interpolation_share = std::max(sampled.interpolation_share, miss / sigma);
  }
}

void add_deviations(const ErrorField& field, SampledError& sampled) {
  std::vector<double> sigmas;
  for (Eigen::Index i = 0; i < sampled.grid.nodes(); ++i) {
    const double stated = sampled.grid.sigmas[i];
    if (sampled.grid.inside[i])
      sigmas.push_back(std::isfinite(stated) ? stated : field.sigma_if_unstated);
  }
  if (sigmas.empty()) throw InputError("the map is valid at no node of the grid");
  sampled.sigma_min = *std::min_element(sigmas.begin(), sigmas.end());
  sampled.sigma_median = median(sigmas);
  if (!(sampled.sigma_min > 0.0))
    throw InputError(Refusal{"the map states no deviation, by which the step of a grid is chosen",
                             "fit it again by --method auto", "", Cause::kMissing});
}

SampledError judged(const ErrorField& field, ErrorGrid sampled) {
  SampledError result{std::move(sampled)};
  add_deviations(field, result);
  const ErrorGrid& grid = result.grid;
  for (Eigen::Index i = 0; i + grid.columns < grid.nodes(); ++i)
    if (i % grid.columns + 1 < grid.columns) judge_cell(field, i, result);
  return result;
}

}  // namespace

ErrorField over_true_places(const ErrorField& seen) {
  const auto place = [seen](const Eigen::Vector2d& p) { return seen_from(seen, p); };
  ErrorField field = seen;
  field.predict = [seen, place](const Eigen::Vector2d& p) { return seen.predict(place(p)); };
  field.error = [seen, place](const Eigen::Vector2d& p) { return seen.error(place(p)); };
  for (Eigen::Vector2d& corner : field.region.hull) corner -= seen.error(corner);
  return field;
}

Eigen::Vector2d ErrorGrid::node(Eigen::Index i) const {
  const Eigen::Index column = i % columns, row = i / columns;
  return origin + step * Eigen::Vector2d(static_cast<double>(column), static_cast<double>(row));
}

Eigen::Vector2d ErrorGrid::error_in_cell(Eigen::Index i, const Eigen::Vector2d& share) const {
  const Eigen::Vector2d a = errors.col(i), b = errors.col(i + 1), c = errors.col(i + columns),
                        d = errors.col(i + columns + 1);
  const double u = share.x(), v = share.y();
  return (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * c + u * d);
}

SampledError sample_error(const ErrorField& field, std::optional<double> step) {
  const Eigen::AlignedBox2d box = box_of(field.region);
  double next = step ? *step : neat(box.sizes().maxCoeff() / kFirstCells);
  for (;;) {
    ErrorGrid grid = sampled(field, next);
    if (!step && !grid.inside.any()) {
      next = neat(0.5 * next);
      continue;
    }
    SampledError found = judged(field, std::move(grid));
    if (found.interpolation_share <= kInterpolationShare) return found;
    if (step)
      throw InputError(
          {fmt::format("a step of {:g} mm costs up to {:.4f} mm between the nodes, {:.2g} of the "
                       "map's deviation there",
                       mm(*step), mm(found.interpolation_max), found.interpolation_share),
           fmt::format("at most {} is allowed; name a smaller step or none", kInterpolationShare)});
    // The cost is that of the field's curvature, which falls with the square of the step.
    const double factor = 0.95 * std::sqrt(kInterpolationShare / found.interpolation_share);
    next = neat(next * std::clamp(factor, 0.2, 0.9));
  }
}

}  // namespace planar
