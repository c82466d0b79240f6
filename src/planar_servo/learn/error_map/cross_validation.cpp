#include "planar_servo/learn/error_map/cross_validation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/learn/error_map/fit/rbf_fit.h"
#include "planar_servo/learn/error_map/fit/sparse_fit.h"

namespace planar {
namespace {

/// A map is worth using when it removes at least this share of the rms error.
constexpr double kSmallestGain = 0.05;
constexpr Eigen::Index kSparsePart = 10000;
constexpr char kUnsolvable[] =
    "the equations of the map without a part of its pairs are too ill conditioned to be solved; "
    "use a smaller width, or let the map choose width and ridge";

std::vector<Eigen::Index> all_but(const Blocks& blocks, std::size_t left_out) {
  std::vector<Eigen::Index> rest;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (i != left_out) rest.insert(rest.end(), blocks[i].begin(), blocks[i].end());
  return rest;
}

/// Returns the residual of each site when its block is left out.
Eigen::Matrix2Xd left_out(const IdwMap&, const MapSites& sites, const Blocks& blocks) {
  Eigen::Matrix2Xd residuals(2, sites.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const MapSites rest = sites.subset(all_but(blocks, b));
    const IdwMap other{rest.positions, rest.errors, {}};
    for (const Eigen::Index i : blocks[b])
      residuals.col(i) = sites.errors.col(i) - other.predict_error(sites.positions.col(i));
  }
  return residuals;
}

/// Does without refitting where the other blocks determine the map's tail.
Eigen::Matrix2Xd left_out(const RbfMap& map, const MapSites& sites, const Blocks& blocks) {
  const RbfParameters& settings = map.parameters();
  Eigen::Matrix2Xd residuals(2, sites.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const MapSites rest = sites.subset(all_but(blocks, b));
    const TailBasis tail = tail_like(settings.tail_basis, rest.positions, rest.directions);
    if (tail.terms() == settings.tail_basis.terms()) {
      const auto found = map.left_out_residuals(blocks[b]);
      if (!found) throw WorkError(kUnsolvable, Cause::kInsufficient);
      residuals(Eigen::all, blocks[b]) = *found;
      continue;
    }
    const RbfMap other = fit_rbf(rest, tail, settings.kernel, settings.ridge).map;
    for (const Eigen::Index i : blocks[b])
      residuals.col(i) =
          sites.errors.col(i) - other.predict_error(sites.positions.col(i), sites.direction(i));
  }
  return residuals;
}

/// Subtracts the block's sums from those over all sites.
Eigen::Matrix2Xd left_out(const SparseRbfMap& map, const MapSites& sites, const Blocks& blocks) {
  const SparseRbfParameters& settings = map.parameters();
  const SparseBasis basis{settings.centers, settings.width, settings.tail_basis,
                          center_factor(settings.centers, settings.width)};
  std::vector<SparseStatistics> of_blocks;
  for (const auto& block : blocks) of_blocks.push_back(statistics_of(basis, sites, block));
  SparseStatistics all = of_blocks.front();
  for (std::size_t b = 1; b < blocks.size(); ++b) all.add(of_blocks[b]);
  Eigen::Matrix2Xd residuals(2, sites.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    SparseStatistics others = all;
    others.add(of_blocks[b], -1.0);
    const auto fit = solve_ridge(others, settings.tail_basis.terms(), settings.ridge);
    if (!fit) throw WorkError(kUnsolvable, Cause::kInsufficient);
    residuals(Eigen::all, blocks[b]) =
        sites.errors(Eigen::all, blocks[b]) -
        (basis.at_each(sites.positions(Eigen::all, blocks[b])) * fit->weights).transpose();
  }
  return residuals;
}

double gap_of(const Eigen::Matrix2Xd& positions, const Blocks& blocks) {
  std::vector<double> gaps;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Eigen::Matrix2Xd others = positions(Eigen::all, all_but(blocks, b));
    double deepest2 = 0.0;
    for (const Eigen::Index i : blocks[b]) {
      const Eigen::Vector2d at = positions.col(i);
      deepest2 = std::max(deepest2, (others.colwise() - at).colwise().squaredNorm().minCoeff());
    }
    gaps.push_back(2.0 * std::sqrt(deepest2));
  }
  return median(gaps);
}

constexpr Eigen::Index kMostBlocks = 20, kFewestBlocks = 5, kSitesPerBlock = 5;

using Site = std::vector<Eigen::Index>::iterator;

void split(const Eigen::Matrix2Xd& positions, Site first, Site last, Eigen::Index count,
           Blocks& blocks) {
  if (count == 1) {
    blocks.emplace_back(first, last);
    std::sort(blocks.back().begin(), blocks.back().end());
    return;
  }
  const Eigen::Matrix2Xd here = positions(Eigen::all, std::vector<Eigen::Index>(first, last));
  const Eigen::Vector2d extent = here.rowwise().maxCoeff() - here.rowwise().minCoeff();
  const Eigen::Index axis = extent.x() >= extent.y() ? 0 : 1;
  const Eigen::Index left = count / 2;
  const Site middle = first + (last - first) * left / count;
  std::nth_element(first, middle, last, [&](Eigen::Index a, Eigen::Index b) {
    return std::pair(positions(axis, a), a) < std::pair(positions(axis, b), b);
  });
  split(positions, first, middle, left, blocks);
  split(positions, middle, last, count - left, blocks);
}

/// Counts the signs of the values from the k-th on with which they and `sum` add up to `wanted`.
long sums_of_at_least(double wanted, const Eigen::ArrayXd& values, Eigen::Index k, double sum) {
  if (k == values.size()) return sum >= wanted ? 1 : 0;
  return sums_of_at_least(wanted, values, k + 1, sum + values[k]) +
         sums_of_at_least(wanted, values, k + 1, sum - values[k]);
}

/// Returns the sum of the sites' values in each block.
Eigen::ArrayXd block_sums(const Eigen::VectorXd& values, const Blocks& blocks) {
  Eigen::ArrayXd sums(static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t b = 0; b < blocks.size(); ++b)
    sums[static_cast<Eigen::Index>(b)] = values(blocks[b]).sum();
  return sums;
}

}  // namespace

Blocks spatial_blocks(const Eigen::Matrix2Xd& positions) {
  const Eigen::Index sites = positions.cols();
  const Eigen::Index fewest = std::min(sites, kFewestBlocks);
  const Eigen::Index count = std::clamp(sites / kSitesPerBlock, fewest, kMostBlocks);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(sites));
  std::iota(order.begin(), order.end(), 0);
  Blocks blocks;
  split(positions, order.begin(), order.end(), count, blocks);
  return blocks;
}

RmsEstimate estimate_rms(const MapSites& sites, const Eigen::Matrix2Xd& means,
                         const Blocks& blocks) {
  const Eigen::ArrayXd sums = block_sums(
      means.colwise().squaredNorm().transpose().cwiseProduct(sites.counts) + sites.scatter, blocks);
  const Eigen::ArrayXd samples = block_sums(sites.counts, blocks);
  const double total = sums.sum();
  const double rms = std::sqrt(total / samples.sum());
  if (!(total > 0.0) || sums.size() < 3) return {rms, rms, rms};
  const double relative = standard_error_of_sum(sums - samples * total / samples.sum()) / total;
  const double factor = std::exp(0.5 * student_t_95(sums.size() - 1) * relative);
  return {rms, rms / factor, rms * factor};
}

bool is_clearly_positive(const Eigen::ArrayXd& values_of_blocks) {
  constexpr long kOneIn = 20;
  constexpr double kRounding = 1e-12;
  const double sum = values_of_blocks.sum();
  if (!(sum > 0.0)) return false;
  const double wanted = sum - kRounding * values_of_blocks.abs().sum();
  return kOneIn * sums_of_at_least(wanted, values_of_blocks, 0, 0.0) <=
         1L << values_of_blocks.size();
}

double student_t_95(Eigen::Index n) {
  const auto freedom = static_cast<double>(n);
  const double z = 1.959964;
  const double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4.0 * freedom) +
         (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * freedom * freedom) +
         (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * freedom * freedom * freedom);
}

CrossValidation cross_validate(const ErrorMap& map, const MapSites& sites) {
  const bool sparse = std::holds_alternative<SparseRbfMap>(map);
  const MapSites part = sites.every(sparse ? sites.size() / kSparsePart + 1 : 1);
  const Blocks blocks = spatial_blocks(part.positions);
  const Eigen::Matrix2Xd residuals =
      std::visit([&](const auto& method) { return left_out(method, part, blocks); }, map);
  return {estimate_rms(part, residuals, blocks), gap_of(part.positions, blocks)};
}

bool is_worth_using(const MapSites& sites, const Eigen::Matrix2Xd& residuals) {
  const double share_left = (1.0 - kSmallestGain) * (1.0 - kSmallestGain);
  const Eigen::VectorXd gains =
      (share_left * sites.errors.colwise().squaredNorm() - residuals.colwise().squaredNorm())
          .transpose()
          .cwiseProduct(sites.counts) -
      (1.0 - share_left) * sites.scatter;
  return is_clearly_positive(block_sums(gains, spatial_blocks(sites.positions)));
}

}  // namespace planar
