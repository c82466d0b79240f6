#include "planar_servo/base/core/decompositions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace planar {

SingularValues singular_values(const Eigen::MatrixXd& A) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return A.ldlt().solve(B);
}

std::optional<Eigen::MatrixXd> solve_positive(Eigen::MatrixXd A, Eigen::MatrixXd B,
                                              double least_rcond) {
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(A);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  if (least_rcond > 0.0 && cholesky.rcond() < least_rcond) return std::nullopt;
  cholesky.solveInPlace(B);
  return B;
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): B is written.
void solve_positive_in_place(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::MatrixXd> B) {
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(A).solveInPlace(B);
}

std::optional<Eigen::MatrixXd> lower_factor(Eigen::MatrixXd A) {
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(A);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  return cholesky.matrixL();
}

// Eigen's solvers take the address of the first coefficient, so what is empty must not reach them.
Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& L, Eigen::MatrixXd B) {
  if (B.size() > 0) L.triangularView<Eigen::Lower>().solveInPlace(B);
  return B;
}

Eigen::MatrixXd solve_lower_transposed(const Eigen::MatrixXd& L, Eigen::MatrixXd B) {
  if (B.size() > 0) L.triangularView<Eigen::Lower>().transpose().solveInPlace(B);
  return B;
}

Eigen::MatrixXd inverse_of_lower(const Eigen::MatrixXd& L) {
  constexpr Eigen::Index kColumns = 64;
  const Eigen::Index n = L.rows();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index first = 0; first < n; first += kColumns) {  // columns begin with zeros
    const Eigen::Index rows = n - first;
    auto columns = inverse.block(first, first, rows, std::min(kColumns, rows));
    L.bottomRightCorner(rows, rows).triangularView<Eigen::Lower>().solveInPlace(columns);
  }
  return inverse;
}

Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return A.colPivHouseholderQr().solve(b);
}

Eigen::MatrixXd orthonormal_span(const Eigen::MatrixXd& A, double threshold) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  qr.setThreshold(threshold);
  return qr.householderQ() * Eigen::MatrixXd::Identity(A.rows(), qr.rank());
}

std::optional<Eigen::VectorXd> leverages(const Eigen::MatrixXd& A, double threshold) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  qr.setThreshold(threshold);
  if (qr.rank() < A.cols()) return std::nullopt;
  const Eigen::MatrixXd thin_q = qr.householderQ() * Eigen::MatrixXd::Identity(A.rows(), A.cols());
  return thin_q.rowwise().squaredNorm();
}

}  // namespace planar
