#include "planar_servo/files/tables/tracker_table.h"

#include <catch2/catch.hpp>

#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("A reading comes back as it was written") {
  const test::TemporaryFolder folder;
  folder.write("tracker.csv", tracker_header() + tracker_line({"t1", 1.5, {1.0, 2.0, -3.0}}));
  CHECK((read_tracker(folder / "tracker.csv").at(0).p_L - Eigen::Vector3d(1.0, 2.0, -3.0)).norm() <
        1e-8);
}

TEST_CASE("Another program's tracker file is read by its own columns") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("leica.csv", "Point;Time;X;Y;Z\nA;0;1000,5;0;-1\n");
  const TrackerDialect dialect{
      {';', true, {{"id", "Point"}, {"t_s", "Time"}, {"x_mm", "X"}, {"y_mm", "Y"}, {"z_mm", "Z"}}}};
  CHECK(read_tracker(path, dialect).at(0).p_L.x() == Approx(1.0005));
}

TEST_CASE("Where a column is missing the header is named, and where all rows are bad the first") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("leica.csv", "Measured points\nP;East;Y;Z\nP1;1;2;3\nP2;4;5;6\n");
  const TrackerDialect dialect{
      {';', false, {{"id", "P"}, {"x_mm", "X"}, {"y_mm", "Y"}, {"z_mm", "Z"}}}};
  CHECK_THROWS_MATCHES(read_tracker(path, dialect), InputError,
                       Refused(Cause::kMissing, "leica.csv:2: there is no column 'X'"));
  folder.write("leica.csv", "Measured points\nP;X;Y;Z\nP1;1,5;2;3\nP2;4,5;5;6\n");
  CHECK_THROWS_MATCHES(read_tracker(path, dialect), InputError,
                       Refused(Cause::kInvalid, "leica.csv:3: x_mm is '1,5'"));
}

TEST_CASE(
    "Tables of tracker programs are read by counted columns, without header, clock or commas") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("points.txt",
                                 "// SpatialAnalyzer export, 2026-11-27\nMeasured points\n\n"
                                 "  \"P 1\"    1.000500    -2.0   0.25   2026-11-27\n"
                                 "\"M1\"\t3.0 four 5.5e-1\n");
  const TrackerDialect dialect{
      {' ', false, {{"id", "1"}, {"x_mm", "2"}, {"y_mm", "3"}, {"z_mm", "4"}}}, 1.0};
  CHECK_THROWS_MATCHES(read_tracker(path, dialect), InputError,
                       Refused(Cause::kInvalid, "points.txt:5: y_mm is 'four'"));
  const auto named =
      folder.write("named.txt", "Title of the job\nID   X      Y    Z\nP1 1.000500 -2.0  0.25\n");
  const TrackerDialect by_name{
      {' ', false, {{"id", "ID"}, {"x_mm", "X"}, {"y_mm", "Y"}, {"z_mm", "Z"}}}, 1.0};
  for (const auto& rows :
       {read_tracker(named, by_name),
        read_tracker(folder.write("plain.txt", "// a\nTitle\nP1 1.000500 -2.0  0.25 2026-11-27\n"),
                     dialect)}) {
    REQUIRE(rows.size() == 1);
    CHECK(rows[0].id == "P1");
    CHECK((rows[0].p_L - Eigen::Vector3d(1.0005, -2.0, 0.25)).norm() < 1e-12);
  }
  CHECK_THROWS_MATCHES(read_tracker(named, by_name, true), InputError,
                       Refused(Cause::kMissing, "'t_s'"));
}

}  // namespace
}  // namespace planar
