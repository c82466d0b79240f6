#pragma once

#include <Eigen/Core>
#include <optional>

namespace planar {

// Eigen's decompositions of matrices whose sizes are known at run time. They are compiled here
// once, because each costs a file that includes it four to twelve seconds. Small matrices that are
// solved for every pixel keep Eigen's own of fixed size.

/// Holds A = U diag(values) V^T. U has as many columns as there are values; V is square.
struct SingularValues {
  Eigen::MatrixXd U;
  Eigen::VectorXd values;  ///< falling
  Eigen::MatrixXd V;
};

SingularValues singular_values(const Eigen::MatrixXd& A);

/// Returns the eigenvalues of a symmetric matrix, rising.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A);

/// Returns X of A X = B for a symmetric positive semidefinite A.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// Returns X of A X = B for a symmetric positive definite A. Empty when A is not positive definite,
/// or when the reciprocal of its condition number is below `least_rcond`.
std::optional<Eigen::MatrixXd> solve_positive(Eigen::MatrixXd A, Eigen::MatrixXd B,
                                              double least_rcond = 0.0);

/// Replaces B by X of A X = B for a symmetric positive definite A, which is overwritten. It takes
/// no memory, for small matrices that are solved for every frame.
void solve_positive_in_place(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::MatrixXd> B);

template <int N>
Eigen::Matrix<double, N, N> inverse_of_positive(Eigen::Matrix<double, N, N> A) {
  Eigen::Matrix<double, N, N> inverse = Eigen::Matrix<double, N, N>::Identity();
  solve_positive_in_place(A, inverse);
  return inverse;
}

/// Returns the lower triangular L of A = L L^T. Empty when A is not positive definite.
std::optional<Eigen::MatrixXd> lower_factor(Eigen::MatrixXd A);

/// Returns X of L X = B, or of L^T X = B, for a lower triangular L; both may be empty.
Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& L, Eigen::MatrixXd B);
Eigen::MatrixXd solve_lower_transposed(const Eigen::MatrixXd& L, Eigen::MatrixXd B);

/// Returns the inverse of a lower triangular matrix.
Eigen::MatrixXd inverse_of_lower(const Eigen::MatrixXd& L);

/// Returns the x with the least |A x - b|.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Returns orthonormal columns that span the columns of A, but for what is smaller than `threshold`
/// times the longest of them.
Eigen::MatrixXd orthonormal_span(const Eigen::MatrixXd& A, double threshold);

/// Returns the leverage of each row, the diagonal of A (A^T A)^-1 A^T. Empty when a column lies
/// within `threshold` of the span of the others.
std::optional<Eigen::VectorXd> leverages(const Eigen::MatrixXd& A, double threshold);

}  // namespace planar
