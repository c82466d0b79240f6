#include "planar_servo/error_map/cross_validation.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/error_map/fit/rbf_fit.h"
#include "planar_servo/error_map/fit/sparse_fit.h"

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

/// Returns the errors at the sites `left_out` that a map with the first one's settings predicts
/// from the sites `rest`.
Eigen::Matrix2Xd predictions(const IdwMap&, const MapSites& rest, const MapSites& left_out) {
  const IdwMap map{rest.positions, rest.errors, {}};
  Eigen::Matrix2Xd errors(2, left_out.size());
  for (Eigen::Index i = 0; i < left_out.size(); ++i)
    errors.col(i) = map.predict_error(left_out.positions.col(i));
  return errors;
}

Eigen::Matrix2Xd predictions(const RbfMap& map, const MapSites& rest, const MapSites& left_out) {
  const RbfParameters& settings = map.parameters();
  const TailBasis tail = tail_like(settings.tail_basis, rest.positions, rest.directions);
  const RbfMap other = fit_rbf(rest, tail, settings.kernel, settings.ridge).map;
  Eigen::Matrix2Xd errors(2, left_out.size());
  for (Eigen::Index i = 0; i < left_out.size(); ++i)
    errors.col(i) = other.predict_error(left_out.positions.col(i), left_out.direction(i));
  return errors;
}

/// Returns the residual of each site when its block is left out.
Eigen::Matrix2Xd left_out(const IdwMap& map, const MapSites& sites, const Blocks& blocks) {
  Eigen::Matrix2Xd residuals(2, sites.size());
  for (std::size_t b = 0; b < blocks.size(); ++b)
    residuals(Eigen::all, blocks[b]) =
        sites.errors(Eigen::all, blocks[b]) -
        predictions(map, sites.subset(all_but(blocks, b)), sites.subset(blocks[b]));
  return residuals;
}

/// Does without refitting where the other blocks determine the map's tail.
Eigen::Matrix2Xd left_out(const RbfMap& map, const MapSites& sites, const Blocks& blocks) {
  Eigen::Matrix2Xd residuals(2, sites.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const MapSites rest = sites.subset(all_but(blocks, b));
    const TailBasis& tail = map.parameters().tail_basis;
    if (tail_like(tail, rest.positions, rest.directions).terms() == tail.terms()) {
      const auto found = map.left_out_residuals(blocks[b]);
      if (!found) throw WorkError(kUnsolvable);
      residuals(Eigen::all, blocks[b]) = *found;
    } else {
      residuals(Eigen::all, blocks[b]) =
          sites.errors(Eigen::all, blocks[b]) - predictions(map, rest, sites.subset(blocks[b]));
    }
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
  for (std::size_t b = 1; b < blocks.size(); ++b) all += of_blocks[b];
  Eigen::Matrix2Xd residuals(2, sites.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    SparseStatistics others = all;
    others -= of_blocks[b];
    const auto fit = solve_ridge(others, settings.tail_basis.terms(), settings.ridge);
    if (!fit) throw WorkError(kUnsolvable);
    residuals(Eigen::all, blocks[b]) =
        sites.errors(Eigen::all, blocks[b]) -
        (basis.at_each(sites.positions(Eigen::all, blocks[b])) * fit->weights).transpose();
  }
  return residuals;
}

MapSites part_for(const ErrorMap& map, const MapSites& sites) {
  const bool sparse = std::holds_alternative<SparseRbfMap>(map);
  return sites.every(sparse ? sites.size() / kSparsePart + 1 : 1);
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

}  // namespace

CrossValidation cross_validate(const ErrorMap& map, const MapSites& sites) {
  const MapSites part = part_for(map, sites);
  const Blocks blocks = spatial_blocks(part.positions);
  const Eigen::Matrix2Xd residuals =
      std::visit([&](const auto& method) { return left_out(method, part, blocks); }, map);
  return {estimate_rms(part, residuals, blocks), gap_of(part.positions, blocks)};
}

bool is_worth_using(const MapSites& sites, const Eigen::Matrix2Xd& residuals) {
  const Blocks blocks = spatial_blocks(sites.positions);
  const double share_left = (1.0 - kSmallestGain) * (1.0 - kSmallestGain);
  const Eigen::VectorXd gains =
      (share_left * sites.errors.colwise().squaredNorm() - residuals.colwise().squaredNorm())
          .transpose()
          .cwiseProduct(sites.counts) -
      (1.0 - share_left) * sites.scatter;
  Eigen::ArrayXd of_blocks(static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t b = 0; b < blocks.size(); ++b)
    of_blocks[static_cast<Eigen::Index>(b)] = gains(blocks[b]).sum();
  return is_clearly_positive(of_blocks);
}

}  // namespace planar
