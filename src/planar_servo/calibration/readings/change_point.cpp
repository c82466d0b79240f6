#include "planar_servo/calibration/readings/change_point.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/core/numerics/chance.h"
#include "planar_servo/core/numerics/decompositions.h"

namespace planar {
namespace {

constexpr Eigen::Index kTerms = 11;
constexpr std::size_t kFewestPlaces = 32;
/// One place is an outlier, not a step.
constexpr Eigen::Index kFewestOnASide = 5;

/// Returns an orthonormal basis of the cubics of the place and the trend in time.
Eigen::MatrixXd smooth_basis(const std::vector<TimedError>& errors) {
  const auto n = static_cast<Eigen::Index>(errors.size());
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const TimedError& e : errors) centre += e.p / static_cast<double>(n);
  double size = 0.0;
  for (const TimedError& e : errors) size = std::max(size, (e.p - centre).norm());
  Eigen::MatrixXd A(n, kTerms);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d at = (errors[static_cast<std::size_t>(i)].p - centre) / size;
    const double x = at.x(), y = at.y();
    A.row(i) << 1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y,
        2.0 * static_cast<double>(i) / static_cast<double>(n) - 1.0;
  }
  return singular_values(A).U;
}

/// Returns the factor by which correlated remainders, in the order of time, make a mean less
/// certain.
double loss_by_correlation(const Eigen::MatrixX2d& left) {
  const Eigen::Index n = left.rows();
  const double together = left.topRows(n - 1).cwiseProduct(left.bottomRows(n - 1)).sum();
  const double r = std::clamp(together / left.squaredNorm(), 0.0, 0.99);
  return (1.0 + r) / (1.0 - r);
}

}  // namespace

std::optional<ChangePoint> find_change(const std::vector<TimedError>& errors) {
  if (errors.size() < kFewestPlaces) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(errors.size());
  const Eigen::MatrixXd Q = smooth_basis(errors);
  Eigen::MatrixX2d left(n, 2);
  for (Eigen::Index i = 0; i < n; ++i)
    left.row(i) = errors[static_cast<std::size_t>(i)].error.transpose();
  left -= Q * (Q.transpose() * left).eval();

  // The step from place k on, less its smooth part, has the square `part` and the product `sum`
  // with the remainders.
  Eigen::RowVector2d sum = Eigen::RowVector2d::Zero();
  Eigen::RowVectorXd smooth = Eigen::RowVectorXd::Zero(kTerms);
  double most = 0.0, part_of_best = 0.0;
  Eigen::Index first = 0;
  Eigen::RowVector2d step = Eigen::RowVector2d::Zero();
  for (Eigen::Index k = n - 1; k >= kFewestOnASide; --k) {
    sum += left.row(k);
    smooth += Q.row(k);
    const double part = static_cast<double>(n - k) - smooth.squaredNorm();
    if (n - k < kFewestOnASide || part <= 1e-6 * static_cast<double>(n)) continue;
    if (sum.squaredNorm() / part <= most) continue;
    most = sum.squaredNorm() / part;
    part_of_best = part;
    first = k;
    step = sum / part;
  }
  if (first == 0) return std::nullopt;
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(n);
  shape.tail(n - first).setOnes();
  shape -= Q * (Q.transpose() * shape).eval();
  left -= shape * step;

  const double loss = loss_by_correlation(left);
  const double degrees = (2.0 * static_cast<double>(n - kTerms) - 2.0) / loss;
  const double variance = left.squaredNorm() / (2.0 * static_cast<double>(n - kTerms) - 2.0);
  const double chance = f_tail_of_two(0.5 * most / (loss * variance), degrees);
  if (!(chance * static_cast<double>(n) < kFalseAlarm)) return std::nullopt;
  return ChangePoint{static_cast<std::size_t>(first), step.transpose(),
                     std::sqrt(loss * variance / part_of_best), std::sqrt(variance)};
}

}  // namespace planar
