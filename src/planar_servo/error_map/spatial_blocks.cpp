#include "planar_servo/error_map/spatial_blocks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "planar_servo/error_map/fit/rbf_fit.h"

namespace planar {
namespace {

constexpr Eigen::Index kMostBlocks = 20;
constexpr Eigen::Index kSitesPerBlock = 5;
constexpr Eigen::Index kFewestBlocks = 5;

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
  const auto count = static_cast<Eigen::Index>(blocks.size());
  const Eigen::VectorXd squares =
      means.colwise().squaredNorm().transpose().cwiseProduct(sites.counts) + sites.scatter;
  Eigen::ArrayXd sums(count);
  Eigen::ArrayXd samples(count);
  for (Eigen::Index b = 0; b < count; ++b) {
    const auto& block = blocks[static_cast<std::size_t>(b)];
    sums[b] = squares(block).sum();
    samples[b] = sites.counts(block).sum();
  }
  const double total = sums.sum();
  const double rms = std::sqrt(total / samples.sum());
  if (!(total > 0.0) || count < 3) return {rms, rms, rms};
  const double relative = standard_error_of_sum(sums - samples * total / samples.sum()) / total;
  const double factor = std::exp(0.5 * student_t_95(count - 1) * relative);
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
  constexpr double kSigmas95 = 1.959964;
  const auto freedom = static_cast<double>(n);
  const double z = kSigmas95;
  const double z3 = z * z * z;
  const double z5 = z3 * z * z;
  const double z7 = z5 * z * z;
  return z + (z3 + z) / (4.0 * freedom) +
         (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * freedom * freedom) +
         (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * freedom * freedom * freedom);
}

}  // namespace planar
