#include "planar_servo/error_map/maps/bordered_system.h"

#include <utility>

#include "planar_servo/core/decompositions.h"

namespace planar {

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

}  // namespace planar
