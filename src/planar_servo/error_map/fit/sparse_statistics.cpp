#include "planar_servo/error_map/fit/sparse_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <future>

#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/error_map/maps/radial_kernel.h"

namespace planar {
namespace {

/// Number of shares of the sites that are summed separately. It is fixed, so that rounding does not
/// depend on the threads.
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
  auto of_gaussians = plain.topRows(centers.cols());
  factor.transpose().triangularView<Eigen::Upper>().solveInPlace(of_gaussians);
  return plain;
}

SparseStatistics& SparseStatistics::operator+=(const SparseStatistics& other) {
  gram += other.gram;
  projected += other.projected;
  squares += other.squares;
  count += other.count;
  return *this;
}

SparseStatistics& SparseStatistics::operator-=(const SparseStatistics& other) {
  gram -= other.gram;
  projected -= other.projected;
  squares -= other.squares;
  count -= other.count;
  return *this;
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
  for (auto& share : shares) sum += share.get();
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
  fit.weights = statistics.projected;
  fit.factor.triangularView<Eigen::Lower>().solveInPlace(fit.weights);
  fit.factor.triangularView<Eigen::Lower>().adjoint().solveInPlace(fit.weights);

  const Eigen::MatrixX2d& w = fit.weights;
  const Eigen::MatrixX2d gram_w = statistics.gram.selfadjointView<Eigen::Lower>() * w;
  fit.residual_squares =
      std::max(0.0, statistics.squares - 2.0 * statistics.projected.cwiseProduct(w).sum() +
                        gram_w.cwiseProduct(w).sum());
  fit.freedom = static_cast<double>(size) - ridge * inverse.leftCols(held).squaredNorm();
  return fit;
}

}  // namespace planar
