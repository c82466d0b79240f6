#include "planar_servo/files/tables/tracker_table.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("Lines of a tracker have names only where their column is told") {
  TrackerLines plain("wire", {});
  CHECK_FALSE(plain.next("id,t_s,x_mm,y_mm,z_mm"));
  const auto reading = plain.next("M1,3,1000,0,0");
  REQUIRE(reading);
  CHECK(reading->id.empty());
  CHECK_FALSE(reading->t_s);
  TrackerLines named("wire", {{',', false, {{"id", "id"}, {"t_s", "t_s"}}}});
  named.next("id,t_s,x_mm,y_mm,z_mm");
  CHECK(named.next("M1,3,1000,0,0")->id == "M1");
  CHECK(named.next("M1,3,1000,0,0")->t_s == 3.0);
}

TEST_CASE("The last digit of a reading is told behind a point and behind a comma") {
  TrackerLines points("wire", {}), commas("wire", {});
  points.next("x_mm,y_mm,z_mm");
  commas.next("x_mm;y_mm;z_mm");
  CHECK(points.next("1000.123,0,0.5")->resolution == Approx(1e-6));
  CHECK(commas.next("1000,123;0;0,5")->resolution == Approx(1e-6));
}

TEST_CASE("Half a line of counted columns is a fault, and a longer one is read") {
  TrackerLines lines("wire", {{' ', false, {{"x_mm", "1"}, {"y_mm", "2"}, {"z_mm", "3"}}}});
  CHECK_THROWS_MATCHES(lines.next("1.5 2"), InputError,
                       Refused(Cause::kInvalid, "wire:1: has 2 fields"));
  CHECK(lines.next("1.5 2 3 ok 7")->p_L.isApprox(Eigen::Vector3d(0.0015, 0.002, 0.003)));
}

TEST_CASE("A header without the coordinates is refused, and a later one is taken") {
  TrackerLines lines("wire", {});
  CHECK_THROWS_MATCHES(lines.next("a,b,c"), InputError,
                       Refused(Cause::kMissing, "x_mm, y_mm, z_mm"));
  CHECK_FALSE(lines.next("z_mm,y_mm,x_mm"));
  CHECK(lines.next("1,2,3")->p_L.x() == 0.003);
}

TEST_CASE("Columns are told as x=X, and what is no column is named") {
  CHECK(renamed_tracker_columns("x=X,id=Point").at("id") == "Point");
  CHECK_THROWS_MATCHES(renamed_tracker_columns("w=X"), InputError,
                       Refused(Cause::kInvalid, "'w=X'"));
  CHECK_THROWS_MATCHES(renamed_tracker_columns("x"), InputError, Refused(Cause::kInvalid, "'x'"));
}

}  // namespace
}  // namespace planar
