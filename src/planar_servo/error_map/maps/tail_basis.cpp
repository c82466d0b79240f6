#include "planar_servo/error_map/maps/tail_basis.h"

#include <cmath>

#include "planar_servo/core/decompositions.h"

namespace planar {
namespace {

/// Positions a thousand times longer than wide count as collinear, because noise would determine
/// the slope across them.
constexpr double kThinnest = 1e-3;

/// A position whose leverage reaches 1 cannot be left out, because the others do not determine the
/// tail.
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
