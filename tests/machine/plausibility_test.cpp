#include "planar_servo/machine/plausibility.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"
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
  CHECK(findings[0].where == key);
  CHECK_THAT(findings[0].fault, Contains(value));
  CHECK_FALSE(findings[0].remedy.empty());
}

TEST_CASE("The cells that stand here are plausible") {
  const auto calib = test::paper_cell_file().parent_path().parent_path();
  for (const char* cell : {"paper", "workshop", "hard", "small", "ordinary", "cheap"}) {
    INFO(cell);
    CHECK(question_values(read_cell(calib / cell / "cell.yaml")).empty());
  }
}

TEST_CASE("Links given in metres or tenths of millimetres are questioned, and what they are") {
  CellSettings cell = paper_cell();
  cell.arm.geometry.link_lengths_m = {0.3e-3, 0.3e-3};
  const auto findings = question_values(cell);
  REQUIRE_FALSE(findings.empty());
  CHECK(findings[0].where == "arm.link_lengths_mm");
  CHECK_THAT(findings[0].fault, Contains("[0.3, 0.3]"));
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
  check_question(cell, "arm.joint_limits_deg[0]", "[-12.5, 3.1]");
  cell.transmission.limits_rad[0] = {-721.0 * kDegree, 3.1 * kDegree};
  check_question(cell, "arm.joint_limits_deg[0]", "[-721, 3.1]");
  cell.transmission.limits_rad[0] = {-720.0 * kDegree, 12.7 * kDegree};
  CHECK(question_values(cell).empty());
}

TEST_CASE("A home pose beyond the limits of a motor is questioned") {
  CellSettings cell = paper_cell();
  const Eigen::Vector3d motors = Transmission(cell.transmission).motors_from_joints(cell.arm.home);
  cell.transmission.limits_rad[1] = {motors[1] + 20.0 * kDegree, motors[1] + 90.0 * kDegree};
  check_question(cell, "arm.home_deg", "motor 2");
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
  check_question(cell, "lamps.separation_mm", "is 400");
  cell.lamps.layout.separation_m = 0.04e-3;
  check_question(cell, "lamps.separation_mm", "is 0.04");
}

TEST_CASE("A keep-out disc in metres is questioned, and one outside the workspace") {
  CellSettings cell = paper_cell();
  cell.workspace.keep_out = {{{0.2e-3, 0.1e-3}, 0.05e-3}};
  check_question(cell, "workspace.keep_out[0]",
                 "is at (0.2, 0.1) with the radius 0.05 mm; metres would be such numbers");
  cell.workspace.keep_out = {{{0.2, 0.1}, 0.05}, {{0.2e-3, 0.1e-3}, 0.05}};
  check_question(cell, "workspace.keep_out[1]", "it lies outside the workspace");
  cell.workspace.keep_out = {{{0.6, 0.0}, 0.05}};
  check_question(cell, "workspace.keep_out[0]", "it lies outside the workspace");
  cell.workspace.keep_out = {{{0.58, 0.0}, 0.05}, {{0.0, 0.0}, 0.061}, {{0.3, 0.0}, 0.001}};
  CHECK(question_values(cell).empty());
}

TEST_CASE("An inner radius in metres is questioned, and none is not") {
  CellSettings cell = paper_cell();
  cell.workspace.radius_min_m = 0.06e-3;
  check_question(cell, "workspace.radius_min_mm", "is 0.06");
  cell.workspace.radius_min_m = 0.0;
  CHECK(question_values(cell).empty());
}

TEST_CASE("Sizes of arm and obstacles in metres are questioned") {
  const auto with = [](auto change) {
    CellSettings cell = paper_cell();
    cell.arm.geometry.body.link_widths_m = {0.06, 0.06};
    cell.workspace.barriers = {{"post", {{-0.3, 0.3}}, 0.05, {0.0, 0.08}}};
    change(cell.arm.geometry.body, cell.workspace.barriers[0]);
    return cell;
  };
  CHECK(question_values(with([](auto&, auto&) {})).empty());
  check_question(with([](auto& body, auto&) { body.link_widths_m[1] = 0.06e-3; }),
                 "arm.link_width_mm", "is 0.06 mm; metres");
  check_question(with([](auto& body, auto&) {
                   body.link_heights[1] = {0.05e-3, 0.09e-3};
                 }),
                 "arm.link_height_mm", "is 0.04 mm; metres");
  check_question(with([](auto& body, auto&) { body.tool_radius_m = 0.03e-3; }),
                 "arm.tool_radius_mm", "is 0.03 mm; metres");
  check_question(with([](auto& body, auto&) {
                   body.tool_heights = {0.0, 0.05e-3};
                 }),
                 "arm.tool_height_mm", "is 0.05 mm; metres");
  check_question(with([](auto&, auto& post) { post.radius_m = 0.05e-3; }),
                 "workspace.obstacles: post", "is 0.05 mm; metres");
  check_question(with([](auto&, auto& post) {
                   post.heights = {0.0, 0.08e-3};
                 }),
                 "workspace.obstacles: post", "is 0.08 mm; metres");
}

TEST_CASE("A home pose at which the arm touches an obstacle is questioned") {
  CellSettings cell = paper_cell();
  cell.arm.geometry.body.link_widths_m = {0.06, 0.06};
  const Eigen::Vector2d end_B = PlanarArm(cell.arm.geometry).forward(cell.arm.home).p;
  cell.workspace.barriers = {{"post", {end_B}, 0.05, {}}};
  check_question(cell, "arm.home_deg", "link 2 would touch the obstacle post");
}

TEST_CASE("A home pose and a direction of the tool in radians are questioned, small angles not") {
  CellSettings cell = paper_cell();
  cell.arm.home = Joints(0.0, 1.0472, -0.785) * kDegree;
  check_question(cell, "arm.home_deg", "0, 1.0472, -0.785");
  for (const double sound : {0.0, 1.0, 1.5, 3.0, 5.0, 6.0}) {
    cell.arm.home = Joints(sound, 0.0, 0.0) * kDegree;
    CHECK(question_values(cell).empty());
  }
  cell.tool_orientation = 1.5708 * kDegree;
  check_question(cell, "tool_orientation_deg", "is 1.5708");
  cell.tool_orientation = 90.0 * kDegree;
  CHECK(question_values(cell).empty());
}

TEST_CASE("A tolerance in micrometres or metres is questioned, and a longest step in metres") {
  CellSettings cell = paper_cell();
  for (const double tolerance_m : {5e-3, 0.9e-6, 5e-9}) {
    cell.servo.tolerance_m = tolerance_m;
    check_question(cell, "servo.tolerance_mm", "0.001 to 0.5 mm");
  }
  cell.servo.tolerance_m = 0.5e-3;
  CHECK(question_values(cell).empty());
  cell.servo.max_step_m = 5e-6;
  check_question(cell, "servo.max_step_mm", "is 0.005");
}

TEST_CASE("A tracker's scatter in micrometres or metres is questioned, and none is not") {
  CellSettings cell = paper_cell();
  for (const double sigma_m : {10e-3, 1e-8}) {
    cell.tracker.sigma_m = sigma_m;
    check_question(cell, "tracker.sigma_mm", "0.0001 to 2 mm");
  }
  cell.tracker.sigma_m = 0.0;
  cell.tracker.sigma_m_per_m = 6e-3;
  check_question(cell, "tracker.sigma_mm_per_m", "is 6");
  cell.tracker.sigma_m_per_m = 0.0;
  cell.tracker.bias_m = 3e-3;
  check_question(cell, "tracker.bias_mm", "is 3");
  cell.tracker.bias_m = 3e-6;
  CHECK(question_values(cell).empty());
}

TEST_CASE("Lamps given in metres are questioned, those on the tool and those on the base") {
  CellSettings cell = read_cell(test::workshop_cell_file());
  cell.lamps.layout.diameters_m[1] = 8e-6;
  check_question(cell, "lamps.diameter_mm[1]", "is 0.008");
  cell = read_cell(test::workshop_cell_file());
  cell.reference_lamps[2].diameter_m = 8e-6;
  check_question(cell, "reference_lamps[2].diameter_mm", "is 0.008");
  cell = read_cell(test::workshop_cell_file());
  for (ReferenceLampLayout& lamp : cell.reference_lamps) *lamp.p_B *= 1e-3;
  check_question(cell, "reference_lamps", "0.66");
  for (ReferenceLampLayout& lamp : cell.reference_lamps) lamp.p_B.reset();
  CHECK(question_values(cell).empty());
}

TEST_CASE("Monuments given in metres are questioned, and none are not") {
  CellSettings cell = paper_cell();
  for (Monument& monument : cell.datum) monument.p_B *= 1e-3;
  check_question(cell, "datum", "0.6");
  cell.datum.clear();
  CHECK(question_values(cell).empty());
}

TEST_CASE("A joint as fast as its motor, or in radians, is questioned") {
  CellSettings cell = paper_cell();
  cell.transmission.drives[1].max_speed_rad_s = 6000.0 * kDegree;
  check_question(cell, "drives[1].max_speed_deg_s", "is 6000");
  cell.transmission.drives[1].max_speed_rad_s = 0.26 * kDegree;
  check_question(cell, "drives[1].max_speed_deg_s", "is 0.26");
}

TEST_CASE("A workspace beyond the arm stretched out, or given in metres, is questioned") {
  CellSettings cell = paper_cell();
  cell.workspace.radius_max_m = 0.601;
  check_question(cell, "workspace.radius_max_mm", "is 601");
  cell.workspace.radius_max_m = 0.54e-3;
  check_question(cell, "workspace.radius_max_mm", "is 0.54");
  cell.workspace.radius_max_m = 0.6;
  CHECK(question_values(cell).empty());
}

}  // namespace
}  // namespace planar
