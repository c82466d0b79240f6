#include "planar_servo/error_map/numerics/tiled_cholesky.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <limits>

#include "planar_servo/error_map/maps/radial_kernel.h"
#include "support/error_fields.h"

namespace planar {
namespace {

// Backward errors, of the matrix and of the identity: Eigen's stay below twice the unit roundoff
// (2.2e-16) times the norm; sums of another order may round a few times as badly.
constexpr double kTimesEigen = 3.0;

/// Gaussians so wide that almost only the ridge keeps them apart: condition above 1e11.
Eigen::MatrixXd wide_kernel(int n) {
  const auto points = test::random_positions(n, 1);
  Eigen::Matrix2Xd positions(2, n);
  for (int i = 0; i < n; ++i) positions.col(i) = points[static_cast<std::size_t>(i)];
  Eigen::MatrixXd lower;
  kernel_matrix({KernelShape::kGaussian, 0.3, 0.0}, squared_distances(positions), lower);
  lower.diagonal().array() += 1e-10;
  return lower.selfadjointView<Eigen::Lower>();
}

TEST_CASE("The tiled factor and its inverse are as accurate as Eigen's") {
  const int n = GENERATE(1, 7, 8, 9, 64, 100, 200, 333);
  const Eigen::MatrixXd matrix = wide_kernel(n);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd expected = matrix.llt().matrixL();
  const Eigen::MatrixXd expected_inverse = expected.triangularView<Eigen::Lower>().solve(identity);
  Eigen::MatrixXd factor = matrix, inverse;
  REQUIRE(TiledCholesky().compute(factor, inverse));
  factor = factor.triangularView<Eigen::Lower>();
  const auto off = [&](const Eigen::MatrixXd& l) { return (l * l.transpose() - matrix).norm(); };
  CHECK(off(factor) <= kTimesEigen * off(expected) + 1e-16 * matrix.norm());
  const double inverse_off = (inverse * factor - identity).norm();
  CHECK(inverse_off <= kTimesEigen * (expected_inverse * expected - identity).norm() + 1e-16);
  CHECK(inverse.triangularView<Eigen::StrictlyUpper>().toDenseMatrix().norm() == 0.0);
}

TEST_CASE("The memory of another matrix leaves no trace in the factor") {
  TiledCholesky used;
  Eigen::MatrixXd inverse;
  for (const int n : {37, 100, 12}) {
    Eigen::MatrixXd matrix = wide_kernel(n), factor = matrix, alone;
    REQUIRE(used.compute(matrix, inverse));
    REQUIRE(TiledCholesky().compute(factor, alone));
    CHECK(matrix.triangularView<Eigen::Lower>().toDenseMatrix() ==
          factor.triangularView<Eigen::Lower>().toDenseMatrix());
    CHECK(inverse == alone);
  }
}

TEST_CASE("Only the lower triangle is read") {
  Eigen::MatrixXd matrix = wide_kernel(20), lower = matrix, inverse, of_lower;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(
      std::numeric_limits<double>::quiet_NaN());
  REQUIRE(TiledCholesky().compute(matrix, inverse));
  REQUIRE(TiledCholesky().compute(lower, of_lower));
  CHECK(inverse == of_lower);
}

TEST_CASE("A matrix that is not positive definite, or not finite, has no tiled factor") {
  const auto [row, column] = GENERATE(std::pair{0, 0}, std::pair{19, 3}, std::pair{19, 19});
  const double value = GENERATE(-1.0, 2.0, std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity());
  if (row == column && value == 2.0) return;
  Eigen::MatrixXd matrix = wide_kernel(20), inverse;
  matrix(row, column) = value;
  CHECK_FALSE(TiledCholesky().compute(matrix, inverse));
}

}  // namespace
}  // namespace planar
