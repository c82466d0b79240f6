#include "error_map/bordered_system.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace planar {
namespace {

/// Columns of L^-1 that are solved for together.
constexpr Eigen::Index kBlock = 32;

// Eigen's solvers take the address of the first coefficient, so an empty right-hand side (there is
// no tail) must not reach them.

template <typename Right>
Eigen::MatrixXd lower_solve(const Eigen::MatrixXd& lower, const Eigen::MatrixBase<Right>& right) {
  Eigen::MatrixXd solution = right;
  if (solution.size() > 0) lower.triangularView<Eigen::Lower>().solveInPlace(solution);
  return solution;
}

void adjoint_solve_in_place(const Eigen::MatrixXd& lower, Eigen::MatrixXd& right) {
  if (right.size() > 0) lower.triangularView<Eigen::Lower>().adjoint().solveInPlace(right);
}

/// Diagonal of (L L^T)^-1: the squared norms of the columns of L^-1, whose column i begins at row
/// i.
Eigen::VectorXd inverse_gram_diagonal(const Eigen::MatrixXd& lower) {
  const Eigen::Index n = lower.rows();
  Eigen::VectorXd diagonal(n);
  for (Eigen::Index first = 0; first < n; first += kBlock) {
    const Eigen::Index rows = n - first;
    const Eigen::Index columns = std::min(kBlock, rows);
    Eigen::MatrixXd block = Eigen::MatrixXd::Identity(rows, columns);
    lower.bottomRightCorner(rows, rows).triangularView<Eigen::Lower>().solveInPlace(block);
    diagonal.segment(first, columns) = block.colwise().squaredNorm();
  }
  return diagonal;
}

}  // namespace

std::optional<BorderedSystem> BorderedSystem::factorize(Eigen::MatrixXd kernel,
                                                        const Eigen::MatrixXd& tail) {
  BorderedSystem system;
  system.factor_ = std::move(kernel);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(system.factor_);
  if (cholesky.info() != Eigen::Success || !system.factor_.diagonal().allFinite()) return {};
  system.tail_ = lower_solve(system.factor_, tail);
  if (tail.cols() == 0) return system;
  const Eigen::LLT<Eigen::MatrixXd> tail_cholesky(system.tail_.transpose() * system.tail_);
  if (tail_cholesky.info() != Eigen::Success) return {};
  system.tail_factor_ = tail_cholesky.matrixL();
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
  Eigen::MatrixXd kernel_inverse_tail = tail_;
  adjoint_solve_in_place(factor_, kernel_inverse_tail);
  const Eigen::MatrixXd removed = lower_solve(tail_factor_, kernel_inverse_tail.transpose());
  return inverse_gram_diagonal(factor_) - removed.colwise().squaredNorm().transpose();
}

double BorderedSystem::inverse_form(const Eigen::VectorXd& k, const Eigen::VectorXd& q) const {
  const Eigen::VectorXd whitened = lower_solve(factor_, k);
  return whitened.squaredNorm() -
         lower_solve(tail_factor_, q - tail_.transpose() * whitened).squaredNorm();
}

double BorderedSystem::pivot_ratio() const {
  const double ratio = factor_.diagonal().minCoeff() / factor_.diagonal().maxCoeff();
  return ratio * ratio;
}

}  // namespace planar
