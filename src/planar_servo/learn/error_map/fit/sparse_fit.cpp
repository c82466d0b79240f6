#include "planar_servo/learn/error_map/fit/sparse_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <limits>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

/// Shares of the sites, summed separately. A fixed number keeps rounding apart from the threads.
constexpr std::size_t kShares = 4;
/// Rows of B that are computed at a time; as many stay in the cache.
constexpr std::size_t kRows = 256;

SparseStatistics empty_statistics(Eigen::Index size) {
  return {Eigen::MatrixXd::Zero(size, size), Eigen::MatrixX2d::Zero(size, 2), 0.0, 0.0};
}

void add_rows(const SparseBasis& basis, const MapSites& sites,
              const std::vector<Eigen::Index>& which, SparseStatistics& sum) {
  const Eigen::VectorXd weights = sites.weights_for(sites.counts(which));
  const Eigen::Matrix2Xd errors = sites.errors(Eigen::all, which);
  Eigen::MatrixXd rows = basis.at_each(sites.positions(Eigen::all, which));
  sum.projected.noalias() += rows.transpose() * (errors * weights.asDiagonal()).transpose();
  rows.array().colwise() *= weights.array().sqrt();
  sum.gram.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
  sum.squares += errors.colwise().squaredNorm().dot(weights);
  if (sites.place_share > 0.0) {
    sum.count += static_cast<double>(which.size());
    return;
  }
  for (const Eigen::Index i : which) sum.squares += sites.scatter[i];
  sum.count += weights.sum();
}

constexpr Eigen::Index kCenters = 400;
constexpr Eigen::Index kTuningPart = 10000;
constexpr int kTailDegree = 3;

/// Widths to try, in distances between centres, until the error grows. Narrower Gaussians would
/// leave gaps between the centres.
constexpr std::array<double, 6> kWidths{1.0, 1.4, 2.0, 2.8, 4.0, 6.0};
/// Steps of ten suffice, because the error is flat about its minimum.
constexpr std::array<double, 6> kRidges{1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0};

/// The limit of the deviation over its largest at a centre; it is larger between centres.
constexpr double kBetweenCenters = 2.0;

constexpr char kSparseUnsolvable[] =
    "the equations of the sparse map are too ill conditioned to be solved with any width and ridge";

/// The least mean number of sites in a cell; with as many a few outliers do not count.
constexpr Eigen::Index kSitesPerCell = 25;

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

/// Has each site judged by those nearest to the same of the first centres, which are spread evenly.
Neighbourhoods cells_of(const Eigen::Matrix2Xd& centers, const Eigen::Matrix2Xd& positions) {
  const Eigen::Index count = std::min(centers.cols(), positions.cols() / kSitesPerCell);
  const Eigen::MatrixX2d by_axis = centers.leftCols(count).transpose();
  Neighbourhoods cells;
  cells.groups.resize(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < positions.cols(); ++i) {
    Eigen::Index nearest = 0;
    ((by_axis.col(0).array() - positions(0, i)).square() +
     (by_axis.col(1).array() - positions(1, i)).square())
        .minCoeff(&nearest);
    cells.of_site.push_back(static_cast<std::size_t>(nearest));
    cells.groups[cells.of_site.back()].push_back(i);
  }
  return cells;
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
  const TailBasis tail = tail_for(part.positions, kTailDegree);
  Tuned best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kWidths.size(); ++i) {
    tell(progress, "choosing width and ridge", i, kWidths.size());
    const double width = kWidths[i] * spacing;
    const SparseBasis basis{centers, width, tail, center_factor(centers, width)};
    const SparseStatistics statistics = statistics_of(basis, part, sites_without({}, part.size()));
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
  throw WorkError(kSparseUnsolvable, Cause::kInsufficient);
}

/// Progress is reported after this many sites.
constexpr std::size_t kSitesAtATime = 50000;

SparseStatistics statistics_of(const SparseBasis& basis, const MapSites& sites,
                               const std::vector<Eigen::Index>& which, const Progress& progress) {
  SparseStatistics sum = empty_statistics(basis.size());
  for (std::size_t first = 0; first < which.size(); first += kSitesAtATime) {
    tell(progress, "summing over the pairs", first, which.size());
    const std::size_t last = std::min(first + kSitesAtATime, which.size());
    sum.add(statistics_of(basis, sites,
                          {which.begin() + static_cast<std::ptrdiff_t>(first),
                           which.begin() + static_cast<std::ptrdiff_t>(last)}));
  }
  return sum;
}

/// Returns the residuals of all sites, kept or not.
Eigen::Matrix2Xd residuals_of(const SparseBasis& basis, const RidgeFit& fit, const MapSites& sites,
                              const Progress& progress) {
  const Eigen::MatrixX2d weights = basis.plain_weights(fit.weights);
  constexpr Eigen::Index kRowsAtOnce = kRows;
  Eigen::Matrix2Xd residuals(2, sites.size());
  for (Eigen::Index first = 0; first < sites.size(); first += kRowsAtOnce) {
    tell(progress, "leaving out outliers", first, sites.size());
    const Eigen::Index n = std::min(kRowsAtOnce, sites.size() - first);
    residuals.middleCols(first, n) =
        sites.errors.middleCols(first, n) -
        (basis.plain_at_each(sites.positions.middleCols(first, n)) * weights).transpose();
  }
  return residuals;
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

Eigen::MatrixXd SparseBasis::plain_at_each(const Eigen::Matrix2Xd& positions) const {
  Eigen::MatrixXd rows(positions.cols(), size());
  const Eigen::MatrixX2d by_axis = positions.transpose();
  const RadialKernel kernel{KernelShape::kGaussian, width, 0.0};
  for (Eigen::Index j = 0; j < centers.cols(); ++j)
    rows.col(j) = kernel_at(kernel, by_axis, centers.col(j));
  rows.rightCols(tail_basis.terms()) = tail_basis.at_each(positions);
  return rows;
}

Eigen::MatrixXd SparseBasis::at_each(const Eigen::Matrix2Xd& positions) const {
  Eigen::MatrixXd rows = plain_at_each(positions);
  auto gaussians = rows.leftCols(centers.cols());
  factor.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(gaussians);
  return rows;
}

Eigen::MatrixX2d SparseBasis::plain_weights(const Eigen::MatrixX2d& weights) const {
  Eigen::MatrixX2d plain = weights;
  plain.topRows(centers.cols()) = solve_lower_transposed(factor, weights.topRows(centers.cols()));
  return plain;
}

void SparseStatistics::add(const SparseStatistics& other, double sign) {
  gram += sign * other.gram;
  projected += sign * other.projected;
  squares += sign * other.squares;
  count += sign * other.count;
}

SparseStatistics statistics_of(const SparseBasis& basis, const MapSites& sites,
                               const std::vector<Eigen::Index>& which) {
  const auto sum_share = [&](std::size_t share) {
    SparseStatistics sum = empty_statistics(basis.size());
    const std::size_t end = which.size() * (share + 1) / kShares;
    for (std::size_t first = which.size() * share / kShares; first < end; first += kRows) {
      const std::size_t last = std::min(first + kRows, end);
      add_rows(basis, sites,
               {which.begin() + static_cast<std::ptrdiff_t>(first),
                which.begin() + static_cast<std::ptrdiff_t>(last)},
               sum);
    }
    return sum;
  };
  std::array<std::future<SparseStatistics>, kShares> shares;
  for (std::size_t i = 0; i < kShares; ++i)
    shares[i] = std::async(std::launch::async, sum_share, i);
  SparseStatistics sum = empty_statistics(basis.size());
  for (auto& share : shares) sum.add(share.get());
  return sum;
}

double RidgeFit::gcv_rms(double count) const {
  return std::sqrt(residual_squares / count) / (1.0 - freedom / count);
}

std::optional<RidgeFit> solve_ridge(const SparseStatistics& statistics, Eigen::Index free,
                                    double ridge) {
  const Eigen::Index size = statistics.gram.rows();
  const Eigen::Index held = size - free;
  Eigen::MatrixXd system = statistics.gram;
  system.diagonal().head(held).array() += ridge;
  auto factor = lower_factor(system);
  if (!factor) return {};
  RidgeFit fit;
  fit.factor = std::move(*factor);
  const Eigen::MatrixXd inverse = inverse_of_lower(fit.factor);
  fit.weights = solve_lower_transposed(fit.factor, solve_lower(fit.factor, statistics.projected));
  const Eigen::MatrixX2d& w = fit.weights;
  const Eigen::MatrixX2d gram_w = statistics.gram.selfadjointView<Eigen::Lower>() * w;
  fit.residual_squares =
      std::max(0.0, statistics.squares - 2.0 * statistics.projected.cwiseProduct(w).sum() +
                        gram_w.cwiseProduct(w).sum());
  fit.freedom = static_cast<double>(size) - ridge * inverse.leftCols(held).squaredNorm();
  return fit;
}

SparseFit fit_sparse(const MapSites& sites, const Progress& progress) {
  const Eigen::Matrix2Xd centers =
      spread_centers(sites.positions(Eigen::all, part_of(sites_without({}, sites.size()))));
  const Neighbourhoods cells = cells_of(centers, sites.positions);
  Outliers dropped = gross_outliers(sites, cells);
  require_few(dropped, sites.size());
  std::vector<Eigen::Index> kept = sites_without(dropped, sites.size());
  const Tuned tuned = tune(centers, sites.subset(part_of(kept)), progress);
  SparseStatistics statistics = statistics_of(tuned.basis, sites, kept, progress);
  for (int round = 1;; ++round) {
    const auto fit = solve_ridge(statistics, tuned.basis.tail_basis.terms(), tuned.ridge);
    if (!fit) throw WorkError(kSparseUnsolvable, Cause::kInsufficient);
    const Eigen::Matrix2Xd residuals = residuals_of(tuned.basis, *fit, sites, progress);
    const Eigen::ArrayXd lengths = residuals.colwise().norm().transpose();
    const Eigen::ArrayXd limits =
        residual_limits(lengths, sites.weights().array().rsqrt(), kept, cells);
    std::vector<Eigen::Index> leaving, coming;
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
    statistics.add(statistics_of(tuned.basis, sites, coming));
    statistics.add(statistics_of(tuned.basis, sites, leaving), -1.0);
    kept = sites_without(dropped, sites.size());
  }
}

}  // namespace planar
