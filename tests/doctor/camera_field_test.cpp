#include "planar_servo/console/doctor/doctor.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;

CellSettings workshop_cell() {
  return read_cell(test::workshop_cell_file());
}

TEST_CASE("A camera that sees all of the workspace is not questioned") {
  CHECK(question_camera_field(workshop_cell()).empty());
}

TEST_CASE("A workspace that reaches out of the picture is questioned, with a place as example") {
  const test::TemporaryFolder folder;
  CellSettings cell = workshop_cell();
  cell.workplane = folder.write("workplane.yaml",
                                test::replaced(read_file(cell.workplane), ", 1528.", ", 1128."));
  const auto findings = question_camera_field(cell);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].verdict == Finding::Verdict::kDoubtful);
  CHECK_THAT(findings[0].fault, Contains("does not see") && Contains("such as ("));
  CHECK_THAT(findings[0].remedy, Contains("workspace.radius_max_mm"));
  cell.workspace.radius_max_m = 0.4;
  CHECK(question_camera_field(cell).empty());
}

TEST_CASE("What the joints do not reach need not be seen") {
  CellSettings cell = workshop_cell();
  const test::TemporaryFolder folder;
  cell.workplane =
      folder.write("workplane.yaml", test::replaced(read_file(cell.workplane), "[7.1", "[307.1"));
  CHECK(question_camera_field(cell).size() == 1);
  for (Eigen::Vector2d& limits : cell.transmission.limits_rad) limits = {-0.1, 0.1};
  cell.arm.home = {0.0, 0.0, 0.0};
  CHECK(question_camera_field(cell).empty());
}

TEST_CASE("Nothing is said of the field before camera and workplane are calibrated") {
  CHECK(question_camera_field(read_cell(test::paper_cell_file())).empty());
}

TEST_CASE("A camera file of another picture size is a fault of the field, not the doctor's end") {
  CellSettings cell = workshop_cell();
  cell.camera.width_px = 512;
  const auto findings = question_camera_field(cell);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].verdict == Finding::Verdict::kFaulty);
  CHECK_THAT(findings[0].fault, Contains("5120 x 5120 px"));
}

}  // namespace
}  // namespace planar
