#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace planar {

/// The symmetric matrix A = [[K, Q], [Q^T, 0]] of kernel interpolation with a polynomial tail,
/// solved through the Cholesky factor K = L L^T. K (N x N) is positive definite; Q (N x m) has full
/// column rank and few columns or none.
class BorderedSystem {
 public:
  /// Factorizes A, reading only the lower triangle of `kernel`. Empty when K is not positive
  /// definite or Q has not full rank to working precision.
  static std::optional<BorderedSystem> factorize(const Eigen::MatrixXd& kernel,
                                                 const Eigen::MatrixXd& tail);

  struct Solution {
    Eigen::MatrixXd weights;  ///< N x c
    Eigen::MatrixXd tail;     ///< m x c
  };
  /// Solves A [weights; tail] = [values; 0] for N x c values.
  Solution solve(const Eigen::MatrixXd& values) const;

  /// Returns the first N elements of the diagonal of A^-1.
  Eigen::VectorXd inverse_diagonal() const;

  /// Returns the rows and columns `of` of A^-1; all are below N.
  Eigen::MatrixXd inverse_block(const std::vector<Eigen::Index>& of) const;

  /// Returns [k; q]^T A^-1 [k; q].
  double inverse_form(const Eigen::VectorXd& k, const Eigen::VectorXd& q) const;

  /// Returns (Q^T K^-1 Q)^-1, m x m: the covariance of the tail if K is that of the values.
  Eigen::MatrixXd tail_covariance() const;

  /// Returns the ratio of the smallest to the largest pivot of K. It bounds the reciprocal
  /// condition number from above and tells how much a sample adds to those before it.
  double pivot_ratio() const;

 private:
  Eigen::MatrixXd factor_;        ///< L
  Eigen::MatrixXd inverse_;       ///< L^-1
  Eigen::MatrixXd tail_;          ///< U = L^-1 Q
  Eigen::MatrixXd tail_factor_;   ///< G of U^T U = G G^T
  Eigen::MatrixXd tail_removed_;  ///< H = G^-1 U^T L^-1; A^-1 begins with K^-1 - H^T H
};

}  // namespace planar
