#include "planar_servo/files/tables/target_table.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

Path path_of(const std::string& text) {
  const test::TemporaryFolder folder;
  return read_path(folder.write("path.csv", text), 0.5);
}

}  // namespace

TEST_CASE("A table of places gives lines, arcs and directions of the tool") {
  const Path path =
      path_of("phi_deg,x_mm,y_mm,via_x_mm,via_y_mm\n,300,200,,\n,400,200,,\n90,400,300,450,250\n");
  CHECK(path.length_m() == Approx(0.1 + 0.05 * kPi));
  CHECK(path.at(0.0).pose.phi == 0.5);
  CHECK(path.at(path.length_m()).pose.phi == Approx(kPi / 2.0));
  CHECK((path.at(0.1 + 0.025 * kPi).pose.p - Eigen::Vector2d(0.45, 0.25)).norm() < 1e-12);
  CHECK(path_of("x_mm,y_mm\n300,200\n400,200\n").length_m() == Approx(0.1));
}

TEST_CASE("A place that cannot be reached from the one before is named by its line") {
  const std::string header = "x_mm,y_mm,via_x_mm,via_y_mm\n";
  CHECK_THROWS_MATCHES(path_of(header + "300,200,,\n300,200,,\n"), InputError,
                       Refused(Cause::kExists, "path.csv:3"));
  CHECK_THROWS_MATCHES(path_of(header + "300,200,,\n400,200,350,200\n"), InputError,
                       Refused(Cause::kInvalid, "path.csv:3"));
  CHECK_THROWS_MATCHES(path_of(header + "300,200,1,2\n400,200,,\n"), InputError,
                       Refused(Cause::kInvalid, "path.csv:2"));
  CHECK_THROWS_MATCHES(path_of(header + "300,200,,\n400,200,350,\n"), InputError,
                       Refused(Cause::kInvalid, "path.csv:3: via_y_mm"));
  CHECK_THROWS_MATCHES(path_of(header + "300,200,,\n"), InputError,
                       Refused(Cause::kInsufficient, "path.csv"));
  CHECK_THROWS_AS(path_of("x_mm,y_mm\n300,nan\n400,200\n"), InputError);
  CHECK_THROWS_MATCHES(path_of("x_mm,y_mm\n300,200\n400,20"), InputError,
                       Refused(Cause::kInvalid, "path.csv:3"));
}

TEST_CASE(
    "A look that found nothing leaves its fields empty, and the truth only stands where known") {
  PathLookRow row;
  row.speed_m_s = 0.01;
  row.look.along_m = 0.1;
  row.look.seen = {0.0998, 2e-5};
  row.look.along_now_m = 0.1001;
  CHECK(row.lag_m() == Approx(0.2e-3));
  CHECK_FALSE(row.lag_truth_m());
  row.truth = PathOffset{0.1, -3e-5};
  CHECK(*row.lag_truth_m() == Approx(0.1e-3));
  const std::string line = path_look_line(row);
  CHECK_THAT(line, Catch::StartsWith("vision,10.000000,"));
  CHECK_THAT(line, Catch::Contains(",0.020000,0.200000,"));
  CHECK_THAT(line, Catch::EndsWith(",-0.030000,0.100000\n"));
  row.look.measurement = failed_look(TipStatus::kNoLamps, "one_lamp", 1.0);
  CHECK_THAT(path_look_line(row), Catch::Contains("one_lamp") && !Catch::Contains("0.200000"));
}

}  // namespace planar
