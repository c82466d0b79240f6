#include "planar_servo/learn/error_map/maps/rbf_basis.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/error_fields.h"

namespace planar {
namespace {

TEST_CASE("Positions over an area carry a linear tail") {
  Eigen::Matrix2Xd positions(2, 4);
  positions << 0, 1, 0, 1, 0, 0, 1, 1;
  const TailBasis tail = tail_for(positions);
  CHECK(tail.degree == 1);
  CHECK(tail.terms() == 3);
  CHECK(tail.at(tail.origin) == Eigen::Vector3d(1.0, 0.0, 0.0));
}

TEST_CASE("A quadratic tail has every product of two coordinates") {
  TailBasis tail;
  tail.degree = 2;
  tail.origin = {1.0, 2.0};
  tail.scale = 2.0;
  Eigen::VectorXd expected(6);
  expected << 1.0, 2.0, 3.0, 4.0, 6.0, 9.0;
  CHECK(tail.at({5.0, 8.0}) == expected);
}

TEST_CASE("A tail is lowered to the degree that the positions determine") {
  Eigen::Matrix2Xd corners(2, 5);
  corners << 0, 1, 0, 1, 0.5, 0, 0, 1, 1, 0.3;
  CHECK(tail_for(corners, 2).degree == 1);
  Eigen::Matrix2Xd circle(2, 20);
  for (int i = 0; i < 20; ++i) circle.col(i) << std::cos(0.3 * i), std::sin(0.3 * i);
  CHECK(tail_for(circle, 2).degree == 1);
  circle.leftCols(10) *= 0.5;
  CHECK(tail_for(circle, 2).degree == 2);
}

TEST_CASE("The tail is only a constant where a slope is not determined") {
  Eigen::Matrix2Xd positions(2, 5);
  positions << 0, 1, 2, 3, 4, 0, 2, 4, 6, 8;
  SECTION("collinear") {}
  SECTION("collinear but for micrometres") {
    positions(0, 2) += 1e-4;
  }
  SECTION("collinear but for one sample, which could not be left out") {
    positions(0, 2) += 3.0;
  }
  SECTION("three samples, of which none could be left out") {
    positions = Eigen::Matrix2Xd(positions.leftCols(3));
    positions(0, 1) += 2.0;
  }
  CHECK(tail_for(positions).degree == 0);
}

}  // namespace
}  // namespace planar
