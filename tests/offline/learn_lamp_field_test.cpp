#include "planar_servo/offline/map/learn_lamp_field.h"

#include <catch2/catch.hpp>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/calibrate_arm.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "support/refused.h"
#include "support/rendered_lamp.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

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
  CHECK_THROWS_MATCHES(laid_dots(rows), InputError, Refused(Cause::kContradiction, "pitch"));
  rows[1].sigma = 0.0;
  CHECK_THROWS_MATCHES(laid_dots(rows), InputError, Refused(Cause::kInvalid, "'a'"));
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
    CHECK_THROWS_MATCHES(pose_samples(cell, {pair}), InputError, Refused(Cause::kMissing, "'p7'"));
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

TEST_CASE("An arm is found with the gears of its cell file") {
  CellSettings cell = read_cell(test::workshop_cell_file());
  cell.transmission.drives[1].gear_ratio = 36.0;
  const Eigen::Vector3d gears(100.0, 36.0, 50.0);
  CHECK(arm_of_files(cell).gear_ratios == gears);
  CHECK(nominal_arm(cell, read_vision(cell, true)).gear_ratios == gears);
}

/// A camera 0.9 m above the base's axis.
VisionCalibration from_above() {
  Pose X_WC = Pose::Identity();
  X_WC.linear() << 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0;
  X_WC.translation().z() = 0.9;
  return {{}, {Pinhole{{1000.0, 1000.0, 499.5, 399.5}}, X_WC}, {}};
}

/// Returns what reads its picture of bright discs, 40 mm wide.
std::function<std::vector<Frame>()> discs_at(const std::vector<Eigen::Vector2d>& places) {
  const cv::Size sensor(1000, 800);
  cv::Mat scene = test::background(sensor);
  for (const Eigen::Vector2d& place : places)
    test::add_lamp(scene, {*from_above().workplane.pixel_from_plane(place), 0.04 * 1000.0 / 0.9});
  std::mt19937 random(1);
  const Frame frame{test::expose(scene, random), cv::Rect({}, sensor)};
  return [frame] { return std::vector<Frame>{frame}; };
}

TEST_CASE("More pictures of a mark do not make its height more certain") {
  const test::TemporaryFolder folder;
  LampFieldFiles files;
  files.marks = folder.write("marks.csv",
                             "id,x_mm,y_mm,kind,size_mm,sigma_z_mm\n"
                             "A,300,0,bright_disc,40,0.5\nB,-300,0,bright_disc,40,0\n");
  files.marks_sigma = 5e-6;
  files.pictures.assign(8, discs_at({{0.3, 0.0}, {-0.3, 0.0}}));
  const LaidDots laid = laid_things(files, from_above(), 0.6);
  REQUIRE(laid.marks.size() == 2);
  // A third of the height's deviation, in one of two directions.
  CHECK(laid.marks[0].sigma == Approx(0.5e-3 / 3.0 / std::sqrt(2.0)).epsilon(0.03));
  CHECK(laid.marks[1].sigma < 20e-6);
}

TEST_CASE("What is not known of a bar's height is common to its sights") {
  const test::TemporaryFolder folder;
  LampFieldFiles files;
  files.bar = folder.write("bar.csv",
                           "id,x_mm,y_mm,kind,size_mm,sigma_z_mm\n"
                           "A,0,0,bright_disc,40,0.5\nB,300,0,bright_disc,40,0.5\n");
  files.bar_sigma = 5e-6;
  files.pictures = {discs_at({{-0.15, 0.0}, {0.15, 0.0}}), discs_at({{0.0, -0.15}, {0.0, 0.15}})};
  const LaidDots laid = laid_things(files, from_above(), 0.6);
  REQUIRE(laid.lengths.size() == 2);
  CHECK(laid.length_sigma == Approx(0.3 * 0.5e-3 / 0.9).epsilon(0.01));
  for (const LengthSight& sight : laid.lengths) CHECK(sight.sigma < 50e-6);
}

TEST_CASE("Marks and bars beyond where lamps were seen do not count") {
  const test::TemporaryFolder folder;
  const std::string table =
      "id,x_mm,y_mm,kind,size_mm\nA,300,0,bright_disc,40\nB,-100,0,bright_disc,40\n";
  LampFieldFiles marks, bar;
  marks.marks = folder.write("marks.csv", table);
  bar.bar = folder.write("bar.csv", table);  // 400 mm long
  marks.pictures = {discs_at({{0.3, 0.0}, {-0.1, 0.0}})};
  bar.pictures = {marks.pictures[0], discs_at({{0.0, -0.2}, {0.0, 0.2}})};
  CHECK(fixed_by(0, laid_things(marks, from_above(), 0.35)).turn == FieldSource::kMarks);
  const LaidDots inner = laid_things(marks, from_above(), 0.25);
  REQUIRE(inner.marks.size() == 1);
  CHECK(inner.marks[0].p_B.x() == Approx(-0.1));
  CHECK(fixed_by(0, inner).turn == FieldSource::kNothing);
  CHECK_THROWS_MATCHES(laid_things(marks, from_above(), 0.05), InputError,
                       Refused(Cause::kInsufficient, "within 50 mm"));
  CHECK(laid_things(bar, from_above(), 0.35).lengths.size() == 2);
  CHECK(laid_things(bar, from_above(), 0.25).lengths.size() == 1);
  CHECK_THROWS_MATCHES(laid_things(bar, from_above(), 0.15), InputError,
                       Refused(Cause::kInsufficient, "within 150 mm"));
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
  for (const char* name : {"pairs.csv", "x_lamp1_mm", "pair a"})
    CHECK_THROWS_MATCHES(require_what_it_needs(field, {pair}, "pairs.csv"), InputError,
                         Refused(Cause::kMissing, name));
}

}  // namespace
}  // namespace planar
