#include "planar_servo/certificate/certify.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/dry_run.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

TEST_CASE("The largest free square of a raster comes first") {
  const std::vector<std::vector<bool>> free{{true, true, false, true},
                                            {true, true, true, true},
                                            {false, true, true, true},
                                            {false, true, true, true}};
  const auto squares = free_squares(free);
  REQUIRE_FALSE(squares.empty());
  CHECK(squares[0].side == 2);
  CHECK(squares[0].column == 3);
  CHECK(squares[0].row == 3);
  CHECK(squares[1].side == 1);
  CHECK(free_squares({{true, false}, {false, true}}).empty());
}

/// Returns the moves that the arm may not make when it comes to them.
std::vector<std::string> barred_moves(const CalibratedCell& cell, const TestPlaces& places) {
  DryRun dry(cell, foresee_check(cell).end);
  std::vector<std::string> barred;
  for (const CertificateMove& move : certificate_moves(places, 2))
    for (const auto& p : {move.p_before, std::optional(move.p_d)})
      if (p && dry.first_move({"", *p, {}}).plan.refusal) barred.push_back(move.id);
  return barred;
}

TEST_CASE("The square and the targets lie where the cell can position") {
  CalibratedCell cell = read_calibrated_cell(read_cell(test::workshop_cell_file()));
  Workspace& workspace = cell.settings.workspace;
  const TestPlaces places = find_test_places(cell, 40);
  CHECK(places.targets.size() == 40);
  CHECK(places.square.side > 0.3);
  CHECK(places.usable > 0.5);
  std::vector<Eigen::Vector2d> all(places.poses.begin(), places.poses.end());
  all.insert(all.end(), places.targets.begin(), places.targets.end());
  for (const Eigen::Vector2d& p : all) {
    CHECK_FALSE(workspace.violation(p));
    CHECK(predict_error_at(*cell.vision, {p, cell.settings.tool_orientation}).inside);
  }

  SECTION("The targets go once round the base and fill the workspace") {
    double turned = -kPi;
    int far = 0;
    for (const Eigen::Vector2d& p : places.targets) {
      const double angle = std::atan2(p.y(), p.x());
      CHECK(angle > turned);
      turned = angle;
      if (p.norm() > workspace.radius_max_m / std::sqrt(2.0)) ++far;
    }
    CHECK(far == Approx(20).margin(6));  // half of the area
  }
  SECTION("A keep-out disc on the square moves it away") {
    workspace.keep_out.push_back({places.square.centre, 0.02});
    const TestPlaces beside = find_test_places(read_calibrated_cell(cell.settings), 1);
    const Eigen::Vector2d apart = beside.square.centre - places.square.centre;
    CHECK(apart.cwiseAbs().maxCoeff() > 0.5 * beside.square.side);
  }
  SECTION("A keep-out disc where a pose is approached from moves the square, too") {
    for (const CertificateMove& approached : certificate_moves(places, 1)) {
      if (approached.from.empty()) continue;
      workspace.keep_out = {{*approached.p_before, 0.002}};
      const TestPlaces beside = find_test_places(read_calibrated_cell(cell.settings), 1);
      for (const CertificateMove& move : certificate_moves(beside, 1))
        CHECK_FALSE(workspace.violation(move.p_before.value_or(move.p_d)));
    }
  }
  SECTION("A keep-out disc between the last pose and the first target bars no move of the run") {
    workspace.keep_out = {{Eigen::Vector2d(0.203, -0.295), 0.006}};
    const CalibratedCell beside = read_calibrated_cell(cell.settings);
    CHECK(barred_moves(beside, find_test_places(beside, 10)).empty());
  }
  SECTION("A workspace that the camera does not see is refused") {
    workspace.keep_out.push_back({{0.0, 0.0}, 0.6});
    CHECK_THROWS_AS(find_test_places(read_calibrated_cell(cell.settings), 1), InputError);
  }
}

}  // namespace
}  // namespace planar
