#include "planar_servo/offline/map/learn_lamp_field.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/calibrate_arm.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

PairRow row(const std::string& id, std::optional<Purpose> plan, double t_s) {
  PairRow pair;
  pair.id = id;
  pair.plan = plan;
  pair.theta = Joints(0.1, 0.3, 0.6);
  pair.lamps_B = {Eigen::Vector2d(0.3, 0.1), Eigen::Vector2d(0.34, 0.1)};
  pair.sigma_vision = 1e-6;
  pair.t_s = t_s;
  if (plan == Purpose::kPose) return pair;
  pair.p_tracker = Eigen::Vector2d(0.32, 0.1);
  pair.p_reflector = Eigen::Vector2d(0.33, 0.09);
  pair.sigma_tracker = 1e-5;
  return pair;
}

TEST_CASE("Places kept for checks tell nothing, and times count from the last of all") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const auto samples =
      pose_samples(cell, {row("a", Purpose::kTrain, 0.0), row("b", Purpose::kPose, 1800.0),
                          row("c", std::nullopt, 3600.0), row("d", Purpose::kTest, 7200.0)});
  REQUIRE(samples.size() == 3);
  CHECK(samples[0].t_h == Approx(-2.0));
  CHECK(samples[2].t_h == Approx(-1.0));
  CHECK(samples[0].reflector_B);
  CHECK_FALSE(samples[1].reflector_B);
  CHECK(samples[1].sigma_lamp == Approx(std::sqrt(2.0) * 1e-6));
  // Relative motors of the paper's cell.
  CHECK((samples[0].motors - Eigen::Vector3d(0.1, 0.2, 0.3)).norm() < 1e-15);
}

TEST_CASE("Dots are sorted into their lays, of one board each with a standard deviation") {
  std::vector<LayRow> rows{{"b", {1.0, 2.0}, {0.1, 0.2}, 1e-6, true},
                           {"a", {3.0, 4.0}, {0.3, 0.4}, 2e-6, true},
                           {"b", {5.0, 6.0}, {0.5, 0.6}, 3e-6, true}};
  const LaidDots board = laid_dots(rows);
  REQUIRE(board.lays.size() == 2);
  CHECK(board.dots() == 3);
  CHECK(board.lays[0].id == "b");
  CHECK(board.lays[0].p_board.col(1) == Eigen::Vector2d(5.0, 6.0));
  CHECK(board.lays[0].seen_B.col(1) == Eigen::Vector2d(0.5, 0.6));
  CHECK(board.lays[0].sigma[1] == 3e-6);
  CHECK(board.pitch_known);
  rows[2].pitch_known = false;
  CHECK_THROWS_WITH(laid_dots(rows), Contains("pitch is known for some lays only"));
  rows[1].sigma = 0.0;
  CHECK_THROWS_WITH(laid_dots(rows), Contains("'a'") && Contains("--lays-out"));
}

TEST_CASE("A pair without lamps, joints or deviations is named") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  for (const auto& spoil :
       {+[](PairRow& pair) { pair.lamps_B.reset(); }, +[](PairRow& pair) { pair.theta.reset(); },
        +[](PairRow& pair) { pair.sigma_vision.reset(); },
        +[](PairRow& pair) { pair.p_reflector.reset(); },
        +[](PairRow& pair) { pair.sigma_tracker.reset(); }}) {
    PairRow pair = row("p7", Purpose::kTrain, 0.0);
    spoil(pair);
    CHECK_THROWS_WITH(pose_samples(cell, {pair}), Contains("pair 'p7' lacks"));
  }
}

TEST_CASE(
    "A tracker errs over the field by a third of its deviation unless its cell says otherwise") {
  CellSettings cell = read_cell(test::workshop_cell_file());
  const VisionCalibration vision = read_vision(cell, true);
  CHECK(nominal_arm(cell, vision).tracker_bias == *cell.tracker.bias_m);
  cell.tracker.bias_m.reset();
  CHECK(nominal_arm(cell, vision).tracker_bias == Approx(cell.tracker.sigma_m / 3.0));
}

TEST_CASE("An arm's readings come from pairs and from samples alike") {
  const CellSettings cell = read_cell(test::paper_cell_file());
  const test::TemporaryFolder folder;
  const auto pairs = folder.write(
      "pairs.csv", pairs_text({row("a", Purpose::kTest, 0.0), row("b", Purpose::kPose, 0.0)}));
  const auto samples = folder.write("samples.csv",
                                    "id,theta1_deg,theta2_deg,theta3_deg,x_mm,y_mm,sigma_mm\n"
                                    "a,5.7295779513,17.1887338539,34.3774677078,330,90,0.01\n");
  const auto by_pairs = read_arm_readings(cell, pairs),
             by_samples = read_arm_readings(cell, samples);
  REQUIRE(by_pairs.size() == 1);
  REQUIRE(by_samples.size() == 1);
  CHECK((by_pairs[0].motors - by_samples[0].motors).norm() < 1e-8);
  CHECK((by_pairs[0].p_B - by_samples[0].p_B).norm() < 1e-12);
  CHECK(by_pairs[0].sigma == Approx(by_samples[0].sigma));
}

TEST_CASE("A field at the lamps is judged where the tracker saw the reflector") {
  LampField field;
  field.basis = basis_over_disc(0.6, 0.2);
  field.weights.setZero(field.basis.terms(), 2);
  field.weights(field.basis.centers.cols(), 0) = 1e-4;  // e_x is 0.1 mm everywhere
  const Eigen::Index n = field.unknowns();
  field.factor.setZero(n, n);
  field.tool.p_TS << 0.01, -0.01, 0.0;
  field.region.hull = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  PairRow pair =
      row("a", Purpose::kTest, 0.0);  // the reflector is where lamps without error put it
  pair.p_vision << 0.32, 0.1;
  pair.p_tracker = Eigen::Vector2d(0.3199, 0.1);
  const MapCheck check = check_error_map(field, {pair});
  CHECK(check.raw.mean == Approx(1e-4));
  CHECK(check.compensated.mean == Approx(1e-4));
  CHECK(check.n_outside == 0);
  pair.p_reflector->x() -= 1e-4;
  CHECK(check_error_map(field, {pair}).compensated.mean < 1e-12);
  pair.lamps_B.reset();
  CHECK_THROWS_WITH(require_what_it_needs(field, {pair}, "pairs.csv"),
                    Contains("pairs.csv") && Contains("x_lamp1_mm") && Contains("pair a"));
}

}  // namespace
}  // namespace planar
