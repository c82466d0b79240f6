#include "planar_servo/calibration/readings/change_point.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/core/numerics/chance.h"
#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/numerics/statistics.h"

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

using ErrorRows = Eigen::MatrixX2d;

/// Returns what the smooth functions leave of errors.
ErrorRows smooth_remainders(const Eigen::MatrixXd& Q, const ErrorRows& errors) {
  return errors - Q * (Q.transpose() * errors).eval();
}

/// Moves outliers to where they stop being any, because one of them beside a few sound places looks
/// like a step.
ErrorRows with_outliers_moved(const Eigen::MatrixXd& Q, ErrorRows errors) {
  constexpr int kRounds = 10;
  constexpr double kMostMedians = 4.0;
  for (int round = 0; round < kRounds; ++round) {
    const ErrorRows left = smooth_remainders(Q, errors);
    const Eigen::VectorXd lengths = left.rowwise().norm();
    const double most = kMostMedians * median({lengths.begin(), lengths.end()});
    for (Eigen::Index i = 0; i < left.rows(); ++i)
      if (lengths[i] > most) errors.row(i) -= (1.0 - most / lengths[i]) * left.row(i);
  }
  return errors;
}

/// A step from place `first` on. Less its smooth part it has the square `part`.
struct Step {
  Eigen::Index first{0};
  double part{0.0};
  Eigen::RowVector2d size{0.0, 0.0};
};

/// Returns the step that takes most away from the remainders' squares; `first` is 0 for none.
Step best_step(const Eigen::MatrixXd& Q, const ErrorRows& left) {
  const Eigen::Index n = left.rows();
  Eigen::RowVector2d sum = Eigen::RowVector2d::Zero();
  Eigen::RowVectorXd smooth = Eigen::RowVectorXd::Zero(kTerms);
  Step best;
  for (Eigen::Index k = n - 1; k >= kFewestOnASide; --k) {
    sum += left.row(k);
    smooth += Q.row(k);
    const double part = static_cast<double>(n - k) - smooth.squaredNorm();
    if (n - k < kFewestOnASide || part <= 1e-6 * static_cast<double>(n)) continue;
    if (sum.squaredNorm() / part <= best.part * best.size.squaredNorm()) continue;
    best = {k, part, sum / part};
  }
  return best;
}

/// Returns the step's shape without its smooth part.
Eigen::VectorXd shape_of(const Eigen::MatrixXd& Q, Eigen::Index first) {
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(Q.rows());
  shape.tail(Q.rows() - first).setOnes();
  return shape - Q * (Q.transpose() * shape).eval();
}

}  // namespace

std::optional<ChangePoint> find_change(const std::vector<TimedError>& errors) {
  if (errors.size() < kFewestPlaces) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(errors.size());
  const Eigen::MatrixXd Q = smooth_basis(errors);
  ErrorRows all(n, 2);
  for (Eigen::Index i = 0; i < n; ++i)
    all.row(i) = errors[static_cast<std::size_t>(i)].error.transpose();
  ErrorRows left = smooth_remainders(Q, with_outliers_moved(Q, all));
  const Step step = best_step(Q, left);
  if (step.first == 0) return std::nullopt;
  const Eigen::VectorXd shape = shape_of(Q, step.first);
  left -= shape * step.size;

  const double loss = loss_by_correlation(left);
  const double degrees = (2.0 * static_cast<double>(n - kTerms) - 2.0) / loss;
  const double variance = left.squaredNorm() / (2.0 * static_cast<double>(n - kTerms) - 2.0);
  const double explained = step.part * step.size.squaredNorm();
  const double chance = f_tail_of_two(0.5 * explained / (loss * variance), degrees);
  if (!(chance * static_cast<double>(n) < kFalseAlarm)) return std::nullopt;
  const Eigen::Vector2d size = smooth_remainders(Q, all).transpose() * shape / step.part;
  return ChangePoint{static_cast<std::size_t>(step.first), size,
                     std::sqrt(loss * variance / step.part), std::sqrt(variance)};
}

}  // namespace planar
