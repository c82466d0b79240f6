#include "planar_servo/base/core/decompositions.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

const Eigen::MatrixXd kTall = (Eigen::MatrixXd(4, 2) << 1, 2, 3, 4, 5, 6, 7, 9).finished();
const Eigen::MatrixXd kPositive = kTall.transpose() * kTall;
const Eigen::MatrixXd kIndefinite = (Eigen::MatrixXd(2, 2) << 1, 2, 2, 1).finished();

TEST_CASE("Singular values and vectors give the matrix again, the values falling") {
  const SingularValues svd = singular_values(kTall);
  CHECK(svd.values[0] > svd.values[1]);
  CHECK((svd.U * svd.values.asDiagonal() * svd.V.transpose() - kTall).norm() < 1e-12);
  CHECK(singular_values(kTall.transpose()).V.cols() == 4);
}

TEST_CASE("The eigenvalues of a symmetric matrix rise") {
  CHECK((symmetric_eigenvalues(kIndefinite) - Eigen::Vector2d(-1.0, 3.0)).norm() < 1e-14);
}

TEST_CASE("Solutions leave no residual, and what cannot be solved has none") {
  const Eigen::MatrixXd B = Eigen::MatrixXd::Identity(2, 2);
  CHECK((kPositive * solve_symmetric(kPositive, B) - B).norm() < 1e-10);
  CHECK((kPositive * solve_positive(kPositive, B).value() - B).norm() < 1e-10);
  CHECK_FALSE(solve_positive(kPositive, B, 0.5).has_value());
  CHECK_FALSE(solve_positive(kIndefinite, B).has_value());
  const Eigen::MatrixXd L = lower_factor(kPositive).value();
  CHECK((L * L.transpose() - kPositive).norm() < 1e-12);
  CHECK(L(0, 1) == 0.0);
  CHECK_FALSE(lower_factor(kIndefinite).has_value());
}

TEST_CASE("The least squares leave a residual at right angles to every column") {
  const Eigen::Vector4d b(1.0, -1.0, 2.0, 0.5);
  const Eigen::VectorXd residual = b - kTall * solve_least_squares(kTall, b);
  CHECK((kTall.transpose() * residual).norm() < 1e-12);
}

TEST_CASE("Leverages are the diagonal of the projection, and dependent columns have none") {
  const Eigen::MatrixXd projection = kTall * solve_positive(kPositive, kTall.transpose()).value();
  CHECK((leverages(kTall, 1e-3).value() - projection.diagonal()).norm() < 1e-10);
  Eigen::MatrixXd dependent = kTall;
  dependent.col(1) = 2.0 * dependent.col(0);
  CHECK_FALSE(leverages(dependent, 1e-3).has_value());
}

}  // namespace
}  // namespace planar
