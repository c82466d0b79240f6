#include "planar_servo/error_map/maps/bordered_system.h"

#include <utility>

#include "planar_servo/core/decompositions.h"

namespace planar {
namespace {

// Eigen's solvers take the address of the first coefficient, so an empty right-hand side (without a
// tail) must not reach them.

template <typename Right>
Eigen::MatrixXd lower_solve(const Eigen::MatrixXd& lower, const Eigen::MatrixBase<Right>& right) {
  Eigen::MatrixXd solution = right;
  if (solution.size() > 0) lower.triangularView<Eigen::Lower>().solveInPlace(solution);
  return solution;
}

void adjoint_solve_in_place(const Eigen::MatrixXd& lower, Eigen::MatrixXd& right) {
  if (right.size() > 0) lower.triangularView<Eigen::Lower>().adjoint().solveInPlace(right);
}

}  // namespace

std::optional<BorderedSystem> BorderedSystem::factorize(const Eigen::MatrixXd& kernel,
                                                        const Eigen::MatrixXd& tail) {
  auto factor = lower_factor(kernel);
  if (!factor || !factor->allFinite()) return {};
  BorderedSystem system;
  system.factor_ = std::move(*factor);
  system.inverse_ = inverse_of_lower(system.factor_);
  system.tail_ = lower_solve(system.factor_, tail);
  system.tail_removed_.resize(tail.cols(), tail.rows());
  if (tail.cols() == 0) return system;
  auto tail_factor = lower_factor(system.tail_.transpose() * system.tail_);
  if (!tail_factor) return {};
  system.tail_factor_ = std::move(*tail_factor);
  Eigen::MatrixXd kernel_inverse_tail = system.tail_;
  adjoint_solve_in_place(system.factor_, kernel_inverse_tail);
  system.tail_removed_ = lower_solve(system.tail_factor_, kernel_inverse_tail.transpose());
  return system;
}

BorderedSystem::Solution BorderedSystem::solve(const Eigen::MatrixXd& values) const {
  Eigen::MatrixXd whitened = lower_solve(factor_, values);
  Eigen::MatrixXd tail = lower_solve(tail_factor_, tail_.transpose() * whitened);
  adjoint_solve_in_place(tail_factor_, tail);
  if (tail.size() > 0) whitened.noalias() -= tail_ * tail;
  adjoint_solve_in_place(factor_, whitened);
  return {std::move(whitened), std::move(tail)};
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
  return whitened.squaredNorm() - (lower_solve(tail_factor_, q) - tail_removed_ * k).squaredNorm();
}

Eigen::MatrixXd BorderedSystem::tail_covariance() const {
  const Eigen::Index terms = tail_.cols();
  const Eigen::MatrixXd inverse =
      lower_solve(tail_factor_, Eigen::MatrixXd::Identity(terms, terms));
  return inverse.transpose() * inverse;
}

double BorderedSystem::pivot_ratio() const {
  const double ratio = factor_.diagonal().minCoeff() / factor_.diagonal().maxCoeff();
  return ratio * ratio;
}

}  // namespace planar
