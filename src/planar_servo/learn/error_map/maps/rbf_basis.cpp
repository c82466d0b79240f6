#include "planar_servo/learn/error_map/maps/rbf_basis.h"

#include <cmath>
#include <utility>

#include "planar_servo/base/core/decompositions.h"

namespace planar {
namespace {

/// The level divided by the largest sqrt(1 + u^2): twice what a disc as wide as the kernel needs.
constexpr double kLevelOverFarthest = 4.0;

/// Replaces squared distances by the kernel there.
void evaluate(const RadialKernel& kernel, Eigen::Ref<Eigen::ArrayXd> values) {
  const double rate = 1.0 / (kernel.width * kernel.width);
  // Numbers that are not normal would slow down all sums.
  constexpr double kLeast = -708.0;
  if (kernel.shape == KernelShape::kGaussian)
    values =
        (-0.5 * rate * values).unaryExpr([](double x) { return x < kLeast ? 0.0 : std::exp(x); });
  else
    values = (1.0 + 1.0 / kernel.level()) - (1.0 + rate * values).sqrt() / kernel.level();
}

/// Positions a thousand times longer than wide are collinear: noise would tell the slope across.
constexpr double kThinnest = 1e-3;

/// A position of leverage 1 cannot be left out, as the others do not determine the tail.
constexpr double kLargestLeverage = 1.0 - kThinnest * kThinnest;

double power(double base, int exponent) {
  double value = 1.0;
  for (int i = 0; i < exponent; ++i) value *= base;
  return value;
}

bool determines(const Eigen::MatrixXd& tail) {
  if (tail.rows() <= tail.cols()) return false;
  const auto leverage = leverages(tail, kThinnest);
  return leverage && leverage->maxCoeff() < kLargestLeverage;
}

}  // namespace

std::optional<BorderedSystem> BorderedSystem::factorize(const Eigen::MatrixXd& kernel,
                                                        const Eigen::MatrixXd& tail) {
  auto factor = lower_factor(kernel);
  if (!factor || !factor->allFinite()) return {};
  BorderedSystem system;
  system.factor_ = std::move(*factor);
  system.inverse_ = inverse_of_lower(system.factor_);
  system.tail_ = solve_lower(system.factor_, tail);
  system.tail_removed_.resize(tail.cols(), tail.rows());
  if (tail.cols() == 0) return system;
  auto tail_factor = lower_factor(system.tail_.transpose() * system.tail_);
  if (!tail_factor) return {};
  system.tail_factor_ = std::move(*tail_factor);
  system.tail_removed_ = solve_lower(
      system.tail_factor_, solve_lower_transposed(system.factor_, system.tail_).transpose());
  return system;
}

BorderedSystem::Solution BorderedSystem::solve(const Eigen::MatrixXd& values) const {
  Eigen::MatrixXd whitened = solve_lower(factor_, values);
  Eigen::MatrixXd tail =
      solve_lower_transposed(tail_factor_, solve_lower(tail_factor_, tail_.transpose() * whitened));
  if (tail.size() > 0) whitened.noalias() -= tail_ * tail;
  return {solve_lower_transposed(factor_, std::move(whitened)), std::move(tail)};
}

Eigen::VectorXd BorderedSystem::inverse_diagonal() const {
  return (inverse_.colwise().squaredNorm() - tail_removed_.colwise().squaredNorm()).transpose();
}

Eigen::MatrixXd BorderedSystem::inverse_block(const std::vector<Eigen::Index>& of) const {
  const Eigen::MatrixXd columns = inverse_(Eigen::all, of);
  const Eigen::MatrixXd removed = tail_removed_(Eigen::all, of);
  return columns.transpose() * columns - removed.transpose() * removed;
}

double BorderedSystem::inverse_form(const Eigen::VectorXd& k, const Eigen::VectorXd& q) const {
  const Eigen::VectorXd whitened = inverse_.triangularView<Eigen::Lower>() * k;
  return whitened.squaredNorm() - (solve_lower(tail_factor_, q) - tail_removed_ * k).squaredNorm();
}

Eigen::MatrixXd BorderedSystem::tail_covariance() const {
  const Eigen::MatrixXd inverse = inverse_of_lower(tail_factor_);
  return inverse.transpose() * inverse;
}

double BorderedSystem::pivot_ratio() const {
  const double ratio = factor_.diagonal().minCoeff() / factor_.diagonal().maxCoeff();
  return ratio * ratio;
}

double RadialKernel::level() const {
  return kLevelOverFarthest * std::hypot(1.0, span / width);
}

double span_of(const Eigen::Matrix2Xd& positions) {
  return (positions.rowwise().maxCoeff() - positions.rowwise().minCoeff()).norm();
}

Eigen::MatrixXd squared_distances(const Eigen::Matrix2Xd& positions) {
  const Eigen::Index n = positions.cols();
  Eigen::MatrixXd distances2(n, n);
  for (Eigen::Index j = 0; j < n; ++j)
    distances2.col(j).tail(n - j) =
        (positions.rightCols(n - j).colwise() - positions.col(j)).colwise().squaredNorm();
  return distances2;
}

void kernel_matrix(const RadialKernel& kernel, const Eigen::MatrixXd& squared_distances,
                   Eigen::MatrixXd& matrix) {
  const Eigen::Index n = squared_distances.cols();
  matrix.resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    matrix.col(j).tail(n - j) = squared_distances.col(j).tail(n - j);
    evaluate(kernel, matrix.col(j).tail(n - j).array());
  }
}

Eigen::VectorXd kernel_at(const RadialKernel& kernel, const Eigen::MatrixX2d& centers,
                          const Eigen::Vector2d& p) {
  Eigen::ArrayXd values =
      (centers.col(0).array() - p.x()).square() + (centers.col(1).array() - p.y()).square();
  evaluate(kernel, values);
  return values;
}

Eigen::VectorXd TailBasis::at(const Eigen::Vector2d& p, const Eigen::Vector2d& direction) const {
  Eigen::VectorXd q(terms());
  const Eigen::Vector2d u = (p - origin) / scale;
  Eigen::Index term = 0;
  for (int total = 0; total <= degree; ++total) {
    for (int y = 0; y <= total; ++y) q[term++] = power(u.x(), total - y) * power(u.y(), y);
  }
  if (with_direction) q.tail<kDirectionTerms>() = direction;
  return q;
}

Eigen::MatrixXd TailBasis::at_each(const Eigen::Matrix2Xd& positions,
                                   const Eigen::Matrix2Xd& directions) const {
  Eigen::MatrixXd q(positions.cols(), terms());
  for (Eigen::Index i = 0; i < positions.cols(); ++i)
    q.row(i) = with_direction ? at(positions.col(i), directions.col(i)) : at(positions.col(i));
  return q;
}

TailBasis tail_for(const Eigen::Matrix2Xd& positions, int degree,
                   const Eigen::Matrix2Xd& directions) {
  TailBasis tail;
  tail.origin = positions.rowwise().mean();
  const auto count = static_cast<double>(positions.cols());
  tail.scale = std::sqrt((positions.colwise() - tail.origin).squaredNorm() / count);
  tail.degree = degree;
  while (tail.degree > 0 && !determines(tail.at_each(positions))) --tail.degree;
  if (directions.cols() == 0) return tail;
  tail.with_direction = true;
  tail.with_direction = determines(tail.at_each(positions, directions));
  return tail;
}

TailBasis tail_like(const TailBasis& basis, const Eigen::Matrix2Xd& positions,
                    const Eigen::Matrix2Xd& directions) {
  if (!basis.with_direction) return tail_for(positions, basis.degree);
  return tail_for(positions, basis.degree, directions);
}

}  // namespace planar
