#include "planar_servo/error_map/fit/sparse_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/error_map/fit/sparse_statistics.h"
#include "planar_servo/error_map/maps/tail_basis.h"

namespace planar {
namespace {

constexpr Eigen::Index kCenters = 400;
constexpr Eigen::Index kTuningPart = 10000;
constexpr int kTailDegree = 3;

/// Widths to try, in distances between centres, until the error grows. Narrower Gaussians would
/// leave gaps between the centres.
constexpr std::array<double, 6> kWidths{1.0, 1.4, 2.0, 2.8, 4.0, 6.0};
/// Steps of ten suffice, because the error is flat about its minimum.
constexpr std::array<double, 6> kRidges{1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0};

/// The limit of a difference from the cell's median over the median difference. Sites beyond it are
/// left out first, before a finer judgement.
constexpr double kGrossDifference = 10.0;
/// The limit of the standard deviation over its largest value at a centre; it is larger between
/// centres.
constexpr double kBetweenCenters = 2.0;

constexpr char kSparseUnsolvable[] =
    "the equations of the sparse map are too ill conditioned to be solved with any width and ridge";

/// The least mean number of sites in a cell; with as many a few outliers do not count.
constexpr Eigen::Index kSitesPerCell = 25;

/// The sites nearest to each of the first centres, which are spread evenly, too.
using Cells = std::vector<std::vector<Eigen::Index>>;

/// Chooses each next centre as the site farthest from those before it [Gonzalez 1985].
Eigen::Matrix2Xd spread_centers(const Eigen::Matrix2Xd& positions) {
  const Eigen::Index count = std::min(kCenters, positions.cols());
  Eigen::Matrix2Xd centers(2, count);
  Eigen::RowVectorXd nearest2 =
      Eigen::RowVectorXd::Constant(positions.cols(), std::numeric_limits<double>::infinity());
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d center = positions.col(next);
    centers.col(i) = center;
    nearest2 = nearest2.cwiseMin((positions.colwise() - center).colwise().squaredNorm());
    nearest2.maxCoeff(&next);
  }
  return centers;
}

Cells cells_of(const Eigen::Matrix2Xd& centers, const Eigen::Matrix2Xd& positions) {
  const Eigen::Index count = std::min(centers.cols(), positions.cols() / kSitesPerCell);
  const Eigen::MatrixX2d by_axis = centers.leftCols(count).transpose();
  Cells cells(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    Eigen::Index nearest = 0;
    ((by_axis.col(0).array() - positions(0, i)).square() +
     (by_axis.col(1).array() - positions(1, i)).square())
        .minCoeff(&nearest);
    cells[static_cast<std::size_t>(nearest)].push_back(i);
  }
  return cells;
}

std::vector<double> values_at(const Eigen::ArrayXd& values, const std::vector<Eigen::Index>& at) {
  const Eigen::ArrayXd chosen = values(at);
  return {chosen.begin(), chosen.end()};
}

/// Returns the sites that differ grossly from the median of their cell.
Outliers gross_outliers(const MapSites& sites, const Cells& cells) {
  Eigen::ArrayXd differences(sites.size());
  for (const auto& cell : cells) {
    if (cell.empty()) continue;
    const Eigen::Vector2d middle(median(values_at(sites.errors.row(0).transpose(), cell)),
                                 median(values_at(sites.errors.row(1).transpose(), cell)));
    for (const Eigen::Index i : cell) differences[i] = (sites.errors.col(i) - middle).norm();
  }
  const double limit = kGrossDifference * median({differences.begin(), differences.end()});
  Outliers gross;
  for (Eigen::Index i = 0; i < sites.size(); ++i)
    if (differences[i] > limit) gross[i] = {i, differences[i], limit};
  return gross;
}

/// Returns all of `kept`, or about kTuningPart of them evenly drawn.
std::vector<Eigen::Index> part_of(const std::vector<Eigen::Index>& kept) {
  const auto stride = kept.size() / kTuningPart + 1;
  std::vector<Eigen::Index> part;
  for (std::size_t i = 0; i < kept.size(); i += stride) part.push_back(kept[i]);
  return part;
}

struct Tuned {
  SparseBasis basis;
  double ridge{0.0};
};

Tuned tune(const Eigen::Matrix2Xd& centers, const MapSites& part, const Progress& progress) {
  const double spacing = median_spacing(centers);
  std::vector<Eigen::Index> all(static_cast<std::size_t>(part.size()));
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Eigen::Index>(i);
  const TailBasis tail = tail_for(part.positions, kTailDegree);
  Tuned best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kWidths.size(); ++i) {
    tell(progress, "choosing width and ridge", i, kWidths.size());
    const double width = kWidths[i];
    const SparseBasis basis{centers, width * spacing, tail,
                            center_factor(centers, width * spacing)};
    const SparseStatistics statistics = statistics_of(basis, part, all);
    double least_of_width = std::numeric_limits<double>::infinity();
    for (const double ridge : kRidges) {
      const auto fit = solve_ridge(statistics, tail.terms(), ridge);
      if (!fit || !(fit->gcv_rms(statistics.count) < least_of_width)) continue;
      least_of_width = fit->gcv_rms(statistics.count);
      if (least_of_width < least) best = {basis, ridge};
    }
    if (!(least_of_width < least)) break;
    least = least_of_width;
  }
  if (std::isfinite(least)) return best;
  throw WorkError(kSparseUnsolvable);
}

/// Progress is reported after this many sites.
constexpr std::size_t kSitesAtATime = 50000;

SparseStatistics statistics_of(const SparseBasis& basis, const MapSites& sites,
                               const std::vector<Eigen::Index>& which, const Progress& progress) {
  SparseStatistics sum = statistics_of(basis, sites, {});
  for (std::size_t first = 0; first < which.size(); first += kSitesAtATime) {
    tell(progress, "summing over the pairs", first, which.size());
    const std::size_t last = std::min(first + kSitesAtATime, which.size());
    sum += statistics_of(basis, sites,
                         {which.begin() + static_cast<std::ptrdiff_t>(first),
                          which.begin() + static_cast<std::ptrdiff_t>(last)});
  }
  return sum;
}

/// Returns the residuals of all sites, kept or not.
Eigen::Matrix2Xd residuals_of(const SparseBasis& basis, const RidgeFit& fit, const MapSites& sites,
                              const Progress& progress) {
  const Eigen::MatrixX2d weights = basis.plain_weights(fit.weights);
  constexpr Eigen::Index kRows = 256;
  Eigen::Matrix2Xd residuals(2, sites.size());
  for (Eigen::Index first = 0; first < sites.size(); first += kRows) {
    tell(progress, "leaving out outliers", first, sites.size());
    const Eigen::Index n = std::min(kRows, sites.size() - first);
    residuals.middleCols(first, n) =
        sites.errors.middleCols(first, n) -
        (basis.plain_at_each(sites.positions.middleCols(first, n)) * weights).transpose();
  }
  return residuals;
}

/// Returns the largest residual of each site with which it is kept.
Eigen::ArrayXd residual_limits(const Eigen::ArrayXd& residuals, const MapSites& sites,
                               const Cells& cells, const Outliers& dropped) {
  const Eigen::VectorXd weights = sites.weights();
  const Eigen::ArrayXd scaled = residuals * weights.array().sqrt();
  const double usual = median({scaled.begin(), scaled.end()}) / residual_length(0.5);
  Eigen::ArrayXd limits = Eigen::ArrayXd::Constant(scaled.size(), usual);
  for (const auto& cell : cells) {
    std::vector<double> kept;
    for (const Eigen::Index i : cell)
      if (dropped.count(i) == 0) kept.push_back(scaled[i]);
    if (kept.empty()) continue;
    const double local = quantile(kept, kLocalShare) / residual_length(1.0 - kLocalShare);
    for (const Eigen::Index i : cell) limits[i] = std::max(usual, local);
  }
  limits *= outlier_sigmas(sites.size()) * weights.array().rsqrt();
  return limits.max(kSmallestOutlier);
}

SparseRbfMap map_of(const Tuned& tuned, const SparseStatistics& statistics, const RidgeFit& fit,
                    const MapSites& sites) {
  const Eigen::Index m = tuned.basis.centers.cols();
  const Eigen::MatrixX2d weights = tuned.basis.plain_weights(fit.weights);
  SparseRbfParameters parameters;
  parameters.centers = tuned.basis.centers;
  parameters.weights = weights.topRows(m).transpose();
  parameters.tail_basis = tuned.basis.tail_basis;
  parameters.tail = weights.bottomRows(weights.rows() - m).transpose();
  parameters.width = tuned.basis.width;
  parameters.ridge = tuned.ridge;
  parameters.factor = fit.factor;
  const double noise2 = fit.residual_squares / (2.0 * (statistics.count - fit.freedom));
  parameters.signal_sigma = std::sqrt(noise2 / tuned.ridge);
  parameters.sigma_limit = std::numeric_limits<double>::infinity();
  parameters.region = region_around(sites.positions, median_spacing(parameters.centers));
  const SparseRbfMap unlimited(parameters);
  parameters.sigma_limit = 0.0;
  for (Eigen::Index i = 0; i < m; ++i)
    parameters.sigma_limit =
        std::max(parameters.sigma_limit,
                 kBetweenCenters * unlimited.predict(parameters.centers.col(i)).sigma);
  return SparseRbfMap(std::move(parameters));
}

}  // namespace

SparseFit fit_sparse(const MapSites& sites, const Progress& progress) {
  const Eigen::Matrix2Xd centers =
      spread_centers(sites.positions(Eigen::all, part_of(sites_without({}, sites.size()))));
  const Cells cells = cells_of(centers, sites.positions);
  Outliers dropped = gross_outliers(sites, cells);
  require_few(dropped, sites.size());
  std::vector<Eigen::Index> kept = sites_without(dropped, sites.size());
  const Tuned tuned = tune(centers, sites.subset(part_of(kept)), progress);
  SparseStatistics statistics = statistics_of(tuned.basis, sites, kept, progress);
  for (int round = 1;; ++round) {
    const auto fit = solve_ridge(statistics, tuned.basis.tail_basis.terms(), tuned.ridge);
    if (!fit) throw WorkError(kSparseUnsolvable);
    const Eigen::Matrix2Xd residuals = residuals_of(tuned.basis, *fit, sites, progress);
    const Eigen::ArrayXd lengths = residuals.colwise().norm().transpose();
    const Eigen::ArrayXd limits = residual_limits(lengths, sites, cells, dropped);
    std::vector<Eigen::Index> leaving;
    std::vector<Eigen::Index> coming;
    for (Eigen::Index i = 0; i < sites.size(); ++i) {
      const bool was_dropped = dropped.count(i) != 0;
      if (lengths[i] > limits[i]) {
        if (!was_dropped) leaving.push_back(i);
        dropped[i] = {i, lengths[i], limits[i]};
      } else if (was_dropped && round <= kRoundsOfTakingBack) {
        coming.push_back(i);
        dropped.erase(i);
      }
    }
    require_few(dropped, sites.size());
    if (leaving.empty() && coming.empty()) {
      const double left_out = 1.0 / (1.0 - fit->freedom / statistics.count);
      SparseRbfMap map = map_of(tuned, statistics, *fit, sites);
      const Eigen::ArrayXd weights = sites.weights()(kept);
      Eigen::VectorXd sigmas = map.noise_sigma() * (left_out / weights).sqrt();
      return {std::move(map), kept, values_of(dropped), residuals(Eigen::all, kept) * left_out,
              std::move(sigmas)};
    }
    statistics += statistics_of(tuned.basis, sites, coming);
    statistics -= statistics_of(tuned.basis, sites, leaving);
    kept = sites_without(dropped, sites.size());
  }
}

}  // namespace planar
