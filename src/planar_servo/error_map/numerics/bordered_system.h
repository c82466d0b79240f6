#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/error_map/numerics/tiled_cholesky.h"

namespace planar {

/// The symmetric matrix A = [[K, Q], [Q^T, 0]] of kernel interpolation on a polynomial tail, with K
/// (N x N) positive definite and Q (N x m, m small, perhaps 0) of full column rank, solved through
/// the Cholesky factor K = L L^T.
class BorderedSystem {
 public:
  /// Only the lower triangle of `kernel` is read. Empty when K is not positive definite or Q not of
  /// full rank to working precision.
  static std::optional<BorderedSystem> factorize(const Eigen::MatrixXd& kernel,
                                                 const Eigen::MatrixXd& tail);

  /// The same in the memory of a system of this size that is no longer wanted; false for empty.
  bool compute(const Eigen::MatrixXd& kernel, const Eigen::MatrixXd& tail);

  struct Solution {
    Eigen::MatrixXd weights;  ///< N x c
    Eigen::MatrixXd tail;     ///< m x c
  };
  /// Solves A [weights; tail] = [values; 0] for N x c values.
  Solution solve(const Eigen::MatrixXd& values) const;

  /// The first N elements of the diagonal of A^-1.
  Eigen::VectorXd inverse_diagonal() const;

  /// The rows and columns `of` of A^-1, all below N.
  Eigen::MatrixXd inverse_block(const std::vector<Eigen::Index>& of) const;

  /// [k; q]^T A^-1 [k; q].
  double inverse_form(const Eigen::VectorXd& k, const Eigen::VectorXd& q) const;

  /// (Q^T K^-1 Q)^-1, m x m: the covariance of the tail where K is that of the values.
  Eigen::MatrixXd tail_covariance() const;

  /// Smallest over largest pivot of K: an upper bound of its reciprocal condition number, and how
  /// much of a sample is new beside those before it.
  double pivot_ratio() const;

 private:
  TiledCholesky cholesky_;        ///< kept for `compute` alone
  Eigen::MatrixXd factor_;        ///< L, in the lower triangle
  Eigen::MatrixXd inverse_;       ///< L^-1
  Eigen::MatrixXd tail_;          ///< U = L^-1 Q
  Eigen::MatrixXd tail_factor_;   ///< G of U^T U = G G^T, in the lower triangle
  Eigen::MatrixXd tail_removed_;  ///< H = G^-1 U^T L^-1: the first N of A^-1 are K^-1 - H^T H
};

}  // namespace planar
