#include "planar_servo/learn/error_map/maps/rbf_basis.h"

#include <catch2/catch.hpp>

#include "planar_servo/learn/error_map/maps/rbf_basis.h"
#include "support/error_fields.h"

namespace planar {
namespace {

// Forty unit kernel elements with a ridge of 1e-2: condition below 1e4.
constexpr double kSystemRounding = 1e-10;
constexpr double kRidge = 1e-2;

struct Example {
  Eigen::MatrixXd kernel;  // both triangles
  Eigen::MatrixXd tail;
};

Example example(int degree) {
  const auto points = test::random_positions(40, 1);
  Eigen::Matrix2Xd positions(2, points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    positions.col(static_cast<Eigen::Index>(i)) = points[i];
  Eigen::MatrixXd lower;
  kernel_matrix({KernelShape::kGaussian, 0.2, 0.0}, squared_distances(positions), lower);
  lower.diagonal().array() += kRidge;
  return {lower.selfadjointView<Eigen::Lower>(),
          TailBasis{degree, {0.0, 0.0}, 0.3}.at_each(positions)};
}

TEST_CASE("A bordered system's solution satisfies its equations") {
  const int degree = GENERATE(-1, 0, 1);
  const Example given = example(degree);
  const auto system = BorderedSystem::factorize(given.kernel, given.tail);
  REQUIRE(system);
  const Eigen::MatrixXd values = Eigen::MatrixXd::Random(40, 2);
  const auto solution = system->solve(values);
  CHECK((given.kernel * solution.weights + given.tail * solution.tail - values).norm() <
        kSystemRounding);
  CHECK((given.tail.transpose() * solution.weights).norm() < kSystemRounding);
}

TEST_CASE("The inverse's diagonal and blocks are those of the solutions for unit values") {
  const int degree = GENERATE(-1, 0, 1);
  const Example given = example(degree);
  const auto system = BorderedSystem::factorize(given.kernel, given.tail);
  REQUIRE(system);
  const Eigen::MatrixXd inverse = system->solve(Eigen::MatrixXd::Identity(40, 40)).weights;
  CHECK((system->inverse_diagonal() - inverse.diagonal()).norm() <
        kSystemRounding * inverse.norm());
  const std::vector<Eigen::Index> some{31, 7, 8};
  CHECK((system->inverse_block(some) - inverse(some, some)).norm() <
        kSystemRounding * inverse.norm());
}

TEST_CASE("The inverse form of A z is z^T A z") {
  const int degree = GENERATE(-1, 0, 1);
  const Example given = example(degree);
  const auto system = BorderedSystem::factorize(given.kernel, given.tail);
  REQUIRE(system);
  const Eigen::VectorXd c = Eigen::VectorXd::Random(40);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(given.tail.cols());
  const Eigen::VectorXd k = given.kernel * c + given.tail * b;
  const Eigen::VectorXd q = given.tail.transpose() * c;
  CHECK(system->inverse_form(k, q) == Approx(c.dot(k) + b.dot(q)).epsilon(kSystemRounding));
}

TEST_CASE("A kernel that is not positive definite and a tail of short rank have no system") {
  Example given = example(1);
  SECTION("kernel") {
    given.kernel(7, 7) = -1.0;
  }
  SECTION("NaN") {
    given.kernel(7, 3) = std::numeric_limits<double>::quiet_NaN();
  }
  SECTION("tail") {
    given.tail.col(2).setZero();
  }
  CHECK_FALSE(BorderedSystem::factorize(given.kernel, given.tail));
}

TEST_CASE("The pivot ratio shows that one sample repeats another") {
  Eigen::Matrix2d kernel;
  kernel << 1.0, 1.0 - 1e-9, 1.0 - 1e-9, 1.0;
  const auto system = BorderedSystem::factorize(kernel, Eigen::MatrixXd(2, 0));
  REQUIRE(system);
  CHECK(system->pivot_ratio() == Approx(2e-9).epsilon(1e-6));
}

}  // namespace
}  // namespace planar
