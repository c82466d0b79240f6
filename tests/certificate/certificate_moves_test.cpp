#include "planar_servo/certificate/certify.h"

#include <catch2/catch.hpp>
#include <set>

namespace planar {
namespace {

TestPlaces places_of(std::size_t targets) {
  TestPlaces places;
  places.square = {{0.3, 0.1}, 0.2};
  places.poses = square_poses(places.square);
  places.targets.assign(targets, {0.1, 0.2});
  return places;
}

TEST_CASE("The poses lie a tenth of the diagonal from the corners, anticlockwise") {
  const auto poses = square_poses({{0.3, 0.1}, 0.2});
  const double half = 0.08;
  CHECK((poses[0] - Eigen::Vector2d(0.3, 0.1)).norm() < 1e-15);
  CHECK((poses[1] - Eigen::Vector2d(0.3 - half, 0.1 - half)).norm() < 1e-15);
  CHECK((poses[2] - Eigen::Vector2d(0.3 + half, 0.1 - half)).norm() < 1e-15);
  CHECK((poses[3] - Eigen::Vector2d(0.3 + half, 0.1 + half)).norm() < 1e-15);
  CHECK((poses[4] - Eigen::Vector2d(0.3 - half, 0.1 + half)).norm() < 1e-15);
}

TEST_CASE("Every pose comes from the one before it, the first from the last") {
  const TestPlaces places = places_of(0);
  const auto moves = certificate_moves(places, 2);
  REQUIRE(moves.size() == 2 * 5 + 2 * 3 * 4);
  for (std::size_t i = 0; i < 10; ++i) {
    CHECK(moves[i].pose == "P" + std::to_string(i % 5 + 1));
    CHECK(moves[i].p_before.value() == places.poses[(i + 4) % 5]);
  }
}

TEST_CASE("P1, P2 and P4 are approached from four sides within the square") {
  const TestPlaces places = places_of(0);
  std::set<std::string> approached;
  for (const CertificateMove& move : certificate_moves(places, 1)) {
    if (move.part != CertificatePart::kDirection) continue;
    approached.insert(move.pose + move.from);
    const Eigen::Vector2d way = *move.p_before - move.p_d;
    CHECK(way.norm() == Approx(0.01));
    CHECK((move.from[1] == 'x' ? way.x() : way.y()) * (move.from[0] == '+' ? 1 : -1) > 0.0);
    CHECK((*move.p_before - places.square.centre).cwiseAbs().maxCoeff() <= 0.1);
  }
  CHECK(approached.size() == 12);
  CHECK(approached.count("P4-y") == 1);
}

TEST_CASE("Every move has an id of its own") {
  std::set<std::string> ids;
  for (const CertificateMove& move : certificate_moves(places_of(120), 101)) ids.insert(move.id);
  CHECK(ids.size() == 101 * 17 + 120);
}

}  // namespace
}  // namespace planar
