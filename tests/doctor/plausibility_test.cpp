#include "planar_servo/doctor/plausibility.h"

#include <catch2/catch.hpp>

#include "planar_servo/core/units.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

using Catch::Contains;

CellSettings paper_cell() {
  return read_cell(test::paper_cell_file());
}

/// Checks that one question is asked of the cell: about this key, with the value in it.
void check_question(const CellSettings& cell, const std::string& key, const std::string& value) {
  const auto findings = question_values(cell);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].verdict == Finding::Verdict::kDoubtful);
  CHECK(findings[0].subject == key);
  CHECK_THAT(findings[0].what, Contains(value));
  CHECK_FALSE(findings[0].remedy.empty());
}

TEST_CASE("The paper's cell and the workshop's are plausible") {
  CHECK(question_values(paper_cell()).empty());
  CHECK(question_values(read_cell(test::workshop_cell_file())).empty());
}

TEST_CASE("Links given in metres or tenths of millimetres are questioned, and what they are") {
  CellSettings cell = paper_cell();
  cell.arm.geometry.link_lengths_m = {0.3e-3, 0.3e-3};
  const auto findings = question_values(cell);
  REQUIRE_FALSE(findings.empty());
  CHECK(findings[0].subject == "arm.link_lengths_mm");
  CHECK_THAT(findings[0].what, Contains("[0.3, 0.3]"));
  CHECK_THAT(findings[0].remedy, Contains("300 for 0.3 m"));
  cell.arm.geometry.link_lengths_m = {5.1, 0.3};
  cell.workspace.radius_max_m = 0.5;
  check_question(cell, "arm.link_lengths_mm", "[5100, 300]");
  cell.arm.geometry.link_lengths_m = {5.0, 0.3};
  CHECK(question_values(cell).empty());
}

TEST_CASE("Limits of a joint that are as small as radians, or beyond two turns, are questioned") {
  CellSettings cell = paper_cell();
  cell.transmission.limits_rad[0] = {-12.5 * kDegree, 3.1 * kDegree};
  check_question(cell, "arm.joint_limits_deg[0]", "is [-12.5, 3.1]; radians would be such numbers");
  cell.transmission.limits_rad[0] = {-721.0 * kDegree, 3.1 * kDegree};
  check_question(cell, "arm.joint_limits_deg[0]", "is [-721, 3.1]; that is beyond two turns");
  cell.transmission.limits_rad[0] = {-720.0 * kDegree, 12.7 * kDegree};
  CHECK(question_values(cell).empty());
}

TEST_CASE("A home pose beyond the limits of a motor is questioned") {
  CellSettings cell = paper_cell();
  const Eigen::Vector3d motors = Transmission(cell.transmission).motors_from_joints(cell.arm.home);
  cell.transmission.limits_rad[1] = {motors[1] + 20.0 * kDegree, motors[1] + 90.0 * kDegree};
  check_question(cell, "arm.home_deg", "the arm cannot go there: motor 2 would turn to");
}

TEST_CASE("Pixels that no sensor has are questioned, and none that some have") {
  CellSettings cell = paper_cell();
  for (const double pitch_m : {2.5e-9, 0.4e-6, 21e-6, 2.5e-3}) {
    cell.camera.pixel_pitch_m = pitch_m;
    check_question(cell, "camera.pixel_pitch_um", "0.5 to 20 um");
  }
  for (const double pitch_m : {0.5 * kMicrometre, 20.0 * kMicrometre}) {
    cell.camera.pixel_pitch_m = pitch_m;
    CHECK(question_values(cell).empty());
  }
  cell.camera.pixel_pitch_m.reset();
  CHECK(question_values(cell).empty());
}

TEST_CASE("Lamps farther apart than the shorter link, or given in metres, are questioned") {
  CellSettings cell = paper_cell();
  cell.lamps.layout.separation_m = 0.4;
  check_question(cell, "lamps.separation_mm", "is 400; the shorter link, 300 mm, is shorter");
  cell.lamps.layout.separation_m = 0.04e-3;
  check_question(cell, "lamps.separation_mm", "is 0.04; the shorter link, 300 mm, is more than a");
}

TEST_CASE("A workspace beyond the arm stretched out, or given in metres, is questioned") {
  CellSettings cell = paper_cell();
  cell.workspace.radius_max_m = 0.601;
  check_question(cell, "workspace.radius_max_mm", "is 601; the arm stretched out, 600 mm");
  cell.workspace.radius_max_m = 0.54e-3;
  check_question(cell, "workspace.radius_max_mm", "is 0.54");
  cell.workspace.radius_max_m = 0.6;
  CHECK(question_values(cell).empty());
}

}  // namespace
}  // namespace planar
