#include "error_map/tail_basis.h"

#include <catch2/catch.hpp>

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
