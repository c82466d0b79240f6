#include "planar_servo/tables/tracker_table.h"

#include <catch2/catch.hpp>

#include "support/temporary_folder.h"

namespace planar {
namespace {

TEST_CASE("A reading comes back as it was written") {
  const test::TemporaryFolder folder;
  folder.write("tracker.csv", tracker_header() + tracker_line({"t1", 1.5, {1.0, 2.0, -3.0}}));
  CHECK((read_tracker(folder / "tracker.csv").at(0).p_L - Eigen::Vector3d(1.0, 2.0, -3.0)).norm() <
        1e-8);
}

TEST_CASE("Another program's tracker file is read by its own columns") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("leica.csv", "Point;Time;X;Y;Z\nA;0;1000,5;0;-1\n");
  const CsvDialect dialect{
      ';', true, {{"id", "Point"}, {"t_s", "Time"}, {"x_mm", "X"}, {"y_mm", "Y"}, {"z_mm", "Z"}}};
  CHECK(read_tracker(path, dialect).at(0).p_L.x() == Approx(1.0005));
}

}  // namespace
}  // namespace planar
