#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "calibration/board_views.h"
#include "field/bent_cell.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/offline/calibrate_arm.h"
#include "planar_servo/offline/calibration_page.h"
#include "planar_servo/offline/lamps_report.h"
#include "planar_servo/offline/map/learn_lamp_field.h"
#include "planar_servo/offline/map/map_report.h"
#include "planar_servo/offline/pairs/pair_page.h"
#include "support/error_fields.h"
#include "support/temporary_folder.h"
#include "support/well_formed.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;

/// What every page must be.
void check_page(const std::string& page) {
  CHECK(test::fault_of_xml(page).empty());
  CHECK(test::is_self_contained(page));
  CHECK(kind_of_text(page) == "page");
  CHECK_THAT(page, !Contains("nan") && !Contains("inf<") && !Contains("-0.000<"));
  CHECK_THAT(page, Contains("What this page was made from"));
}

bool has_fault(const Verdict& verdict, const std::string& words) {
  for (const Refusal& fault : verdict.faults)
    if (fault.fault.find(words) != std::string::npos) return true;
  return false;
}

CameraCalibration calibrated() {
  return calibrate_camera(
      test::views_of_board(PlumbBob{test::kIntrinsics, -0.15}, 12, "plumb_bob_k1"));
}

/// Puts a point without a residual into each corner of the picture.
void cover_corners(CameraCalibration& found) {
  for (const double u : {5.0, found.width_px - 5.0})
    for (const double v : {5.0, found.height_px - 5.0}) {
      found.views[0].pixels.emplace_back(u, v);
      found.views[0].residuals_px.emplace_back(0.0, 0.0);
    }
}

void uncover_upper_left(CameraCalibration& found) {
  for (CalibratedView& view : found.views)
    for (std::size_t i = view.pixels.size(); i-- > 0;) {
      if (view.pixels[i].maxCoeff() > 300.0) continue;
      view.pixels.erase(view.pixels.begin() + static_cast<std::ptrdiff_t>(i));
      view.residuals_px.erase(view.residuals_px.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

TEST_CASE("A camera's page has the figures that were computed") {
  const test::TemporaryFolder folder;
  CameraCalibration found = calibrated();
  found.rejected.push_back({"dark <1>", "no grid of 9 x 7 dots"});
  const auto file = folder.write("camera.yaml", "format: planar-servo/camera/1\n");
  const std::string page = camera_page(found, file, {file});
  check_page(page);
  const Intrinsics k = intrinsics(found.camera);
  CHECK_THAT(page,
             Contains(fmt::format("<td>{:.2f} +- {:.2f}, ", k.cx, found.standard_deviations[2])));
  CHECK_THAT(page, Contains(fmt::format(" {:.3f} px in views left out", *found.held_out_rms_px)));
  CHECK_THAT(page, Contains(fmt::format("at most {:.4f} mm</td>",
                                        found.plane_error.largest() / kMillimetre)));
  CHECK_THAT(page, Contains("dark &lt;1&gt;"));
}

TEST_CASE("A camera is judged by corners without a board, odd views and views left out") {
  CameraCalibration found = calibrated();
  cover_corners(found);
  CHECK(camera_verdict(found).faults.empty());
  CHECK_THAT(camera_verdict(found).good, Contains("12 views agree to 0.0"));
  CHECK_THAT(camera_verdict(found).good,
             Contains("points come within 7 px of every corner of the image"));
  found.views[3].rms_px *= 3.0;
  CHECK(has_fault(camera_verdict(found), "view3 is met to"));
  found = calibrated();
  cover_corners(found);
  uncover_upper_left(found);
  CHECK(has_fault(camera_verdict(found), "a corner of the image was not seen: upper left"));
  *found.held_out_rms_px = 2.0 * found.rms_px;
  CHECK(has_fault(camera_verdict(found), "views left out of the fit are met to"));
  found.held_out_rms_px.reset();
  CHECK(has_fault(camera_verdict(found), "too few to judge"));
}

TEST_CASE("Residuals that neighbours share are told from noise") {
  CameraCalibration found = calibrated();
  const ImageCoverage noise = coverage_of(found);
  CHECK(noise.common_px < 0.5 * found.rms_px);
  CHECK_FALSE(noise.is_systematic());
  CHECK((noise.by_chance > 0.0 && noise.by_chance < 0.2));
  for (CalibratedView& view : found.views)
    for (std::size_t i = 0; i < view.pixels.size(); ++i)
      view.residuals_px[i] += Eigen::Vector2d(0.3 * std::sin(0.005 * view.pixels[i].x()), 0.0);
  CHECK(coverage_of(found).common_px == Approx(0.3 / std::sqrt(2.0)).epsilon(0.2));
}

/// Adds a smooth field to the residuals, which then has this share of their mean square.
void add_field(CameraCalibration& found, double share) {
  const double noise = found.rms_px;
  const double size = noise * std::sqrt(2.0 * share / (1.0 - share));
  found.rms_px = noise / std::sqrt(1.0 - share);
  for (CalibratedView& view : found.views)
    for (std::size_t i = 0; i < view.pixels.size(); ++i)
      view.residuals_px[i].x() += size * std::sin(0.005 * view.pixels[i].x());
}

TEST_CASE("A camera whose residuals are mostly systematic is not called good") {
  CameraCalibration mostly = calibrated(), less = calibrated();
  add_field(mostly, 0.65);
  add_field(less, 0.35);
  cover_corners(mostly);
  cover_corners(less);
  CHECK(coverage_of(mostly).systematic == Approx(0.65).margin(0.1));
  CHECK(has_fault(camera_verdict(mostly), "mostly systematic, not noise"));
  CHECK_THAT(camera_verdict(mostly).faults.back().remedy, Contains("--model auto"));
  CHECK(camera_verdict(less).faults.empty());
  CHECK_THAT(camera_verdict(less).good, Contains("of their square is systematic"));
}

/// Three images of each of `places`, of the given noise, which they state as 0.02 px.
LocateReport located(int places, double noise_px) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, noise_px);
  LocateReport report;
  for (int i = 0; i < 3 * places; ++i) {
    LampRow row;
    const int place = i / 3;
    row.id = "p" + std::to_string(place);
    row.image = "images/" + std::to_string(i) + ".png";
    row.status = LampStatus::kOk;
    for (const double u : {100.0, 200.0})
      row.uv_px.emplace_back(u + 10.0 * place + noise(random), 300.0 + noise(random));
    row.covariance_px2.assign(2, 4e-4 * Eigen::Matrix2d::Identity());
    report.rows.push_back(row);
  }
  return report;
}

TEST_CASE("The scatter of images at rest has the size that one image is off") {
  double squares = 0.0;
  const std::vector<RepeatedSight> sights = repeated_sights(located(200, 0.02).rows);
  REQUIRE(sights.size() == 1200);
  for (const RepeatedSight& sight : sights) squares += sight.pull.squaredNorm() / 2400.0;
  CHECK(std::sqrt(squares) == Approx(1.0).epsilon(0.08));
}

TEST_CASE("Lamps are judged by images without them and by what moves at rest") {
  const test::TemporaryFolder folder;
  LocateReport report = located(30, 0.02);
  CHECK(lamps_verdict(report).faults.empty());
  CHECK_THAT(lamps_verdict(report).good, Contains("90 of 90 images"));
  CHECK(has_fault(lamps_verdict(located(30, 0.06)), "scatter by"));
  for (std::size_t i = 0; i < 9; ++i) {
    LampRow& row = report.rows[10 * i];
    row.status = LampStatus::kSaturated;
    row.uv_px.clear();
    row.covariance_px2.clear();
  }
  CHECK(has_fault(lamps_verdict(report), "9 of 90 images are saturated"));
  CHECK_THAT(lamps_verdict(report).faults[0].remedy, Contains("expose shorter"));
  const std::string page =
      lamps_page(report, folder.write("lamps.csv", "# format: planar-servo/lamps/1\n"), {});
  check_page(page);
  CHECK_THAT(page, Contains("at the bottom: 9 images without lamps") &&
                       Contains("<th scope=\"row\">images/80.png</th><td>saturated</td>"));
}

TEST_CASE("A page of images without any lamp says so and has no figure") {
  const test::TemporaryFolder folder;
  LocateReport report;
  report.rows.resize(2);
  const std::string page = lamps_page(report, folder.write("lamps.csv", "\n"), cv::Size(100, 80));
  check_page(page);
  CHECK_THAT(page, Contains("2 of 2 images are no_lamp") && !Contains("<svg"));
}

/// Pairs on a spiral with a smooth error, and readings of monuments and places.
struct Paired {
  PairTrackerRequest request;
  PairTrackerReport report;
};

Paired paired() {
  Paired paired;
  paired.request.cell.tracker.sigma_m = 10e-6;
  for (int i = 0; i < 40; ++i) {
    const double r = 0.1 + 0.01 * i, a = 2.4 * i;
    PairRow pair;
    pair.id = "t" + std::to_string(i);
    pair.p_vision = r * Eigen::Vector2d(std::cos(a), std::sin(a));
    pair.p_tracker = pair.p_vision - 1e-4 * Eigen::Vector2d(std::sin(5.0 * r), 0.5);
    pair.t_s = 10.0 * i;
    pair.plan = Purpose::kTrain;
    paired.report.pairs.push_back(pair);
    for (const double off : {-10e-6, 10e-6})
      paired.request.tracker.push_back({pair.id, 10.0 * i, {1.0 + off / std::sqrt(2.0), 0.0, 0.0}});
  }
  paired.report.datum = DatumRegistration{};
  paired.report.datum->rms = 7e-6;
  paired.report.datum->residuals = {{"d1", 3, {12.3e-6, 0.0, -4e-6}}};
  return paired;
}

TEST_CASE("The page of pairs shows error, monuments and what was left out") {
  const test::TemporaryFolder folder;
  Paired ours = paired();
  CHECK(pair_verdict(ours.request, ours.report).faults.empty());
  CHECK_THAT(pair_verdict(ours.request, ours.report).good,
             Contains("40 pairs") && Contains("0.0070 mm"));
  ours.report.rejected.push_back({"t99", "no reading"});
  const auto file = folder.write("pairs.csv", "# format: planar-servo/pairs/1\n");
  const std::string page = pair_page(ours.request, ours.report, file);
  check_page(page);
  CHECK_THAT(page, Contains("<th scope=\"row\">d1</th><td>3</td><td>0.0123</td><td>0.0000</td>"
                            "<td>-0.0040</td>"));
  CHECK_THAT(page,
             Contains("time, min") && Contains("<th scope=\"row\">t99</th><td>no reading</td>"));
  // Two readings 14 um apart along one of three axes.
  CHECK_THAT(page, Contains("spread by 0.0058 mm per axis"));
}

TEST_CASE("Pairs are judged by doubts and by how many were left out") {
  Paired ours = paired();
  ours.report.doubts = {{"monument d1: it moved by 0.4 mm", "measure it again"}};
  const Verdict doubted = pair_verdict(ours.request, ours.report);
  REQUIRE(doubted.faults.size() == 1);
  CHECK(doubted.faults[0].fault == "monument d1: it moved by 0.4 mm");
  CHECK(doubted.faults[0].remedy == "measure it again");
  ours = paired();
  ours.report.rejected.assign(10, {"t", "why"});
  CHECK(has_fault(pair_verdict(ours.request, ours.report), "10 of 50 places"));
}

TEST_CASE("Poses that no tracker watched have a page without errors") {
  const test::TemporaryFolder folder;
  Paired ours = paired();
  for (PairRow& pair : ours.report.pairs) pair.p_tracker.reset();
  ours.report.datum.reset();
  ours.request.tracker.clear();
  const std::string page = pair_page(ours.request, ours.report, folder.write("pairs.csv", "\n"));
  check_page(page);
  CHECK_THAT(page, Contains("40 poses were seen; no tracker reading judges them"));
}

FitErrorMapReport fitted(const test::ErrorField& field, double noise) {
  std::vector<PairRow> pairs;
  for (const ErrorSample& sample : test::measure(field, test::random_positions(120, 3), noise, 4)) {
    PairRow pair;
    pair.id = sample.id;
    pair.p_vision = sample.p_vision;
    pair.p_tracker = sample.p_vision - sample.error;
    pairs.push_back(pair);
  }
  return fit_error_map_to_pairs(pairs, {});
}

TEST_CASE(
    "The page of a map shows it, its uncertainty, and what is left where places are left out") {
  const test::TemporaryFolder folder;
  const FitErrorMapReport report = fitted(test::lens_field, test::kFieldNoise);
  const MapView view =
      view_of(report, map_fit_list(report, {{"idw < rbf", 1e-5, {2e-5, 1e-5, 3e-5}}}));
  CHECK(view.verdict.faults.empty());
  REQUIRE(view.left.size() == report.result.n_places);
  double squares = 0.0;
  for (const Eigen::Vector2d& left : view.left) squares += left.squaredNorm();
  CHECK(std::sqrt(squares / static_cast<double>(view.left.size())) ==
        Approx(report.result.loo_rms));
  const std::string page = map_page(view, folder.write("map.yaml", "format: planar-servo/map/1\n"));
  check_page(page);
  CHECK_THAT(page, Contains("How uncertain it is") &&
                       Contains("<th scope=\"row\">pairs used</th><td>120 (0 rejected)</td>") &&
                       Contains("<th scope=\"row\">idw &lt; rbf</th><td>0.0100</td>"
                                "<td>0.0200</td><td>0.0100 to 0.0300</td>") &&
                       Contains("<th scope=\"row\">rotation</th><td>"));
  CHECK_THAT(page, Contains(fmt::format("Left out, with the map: {:.4f} mm rms",
                                        report.result.loo_rms / kMillimetre)));
  CHECK_THAT(page, Contains(fmt::format("(95&#160;% interval {:.4f} to {:.4f})",
                                        report.result.blocked.low / kMillimetre,
                                        report.result.blocked.high / kMillimetre)));
}

TEST_CASE("A map of noise is called useless, with what to do") {
  const FitErrorMapReport report =
      fitted([](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); }, 1e-4);
  const Verdict verdict = map_verdict(report);
  CHECK(has_fault(verdict, "not worth using"));
  CHECK_THAT(verdict.faults[0].remedy, Contains("--no-error-map"));
}

TEST_CASE("A map that fails in gaps is said to help close to its places alone") {
  FitErrorMapReport report = fitted(test::lens_field, test::kFieldNoise);
  report.result.gap = 43.4e-3;
  report.result.blocked.value = 1.25 * report.result.raw_rms;
  const Verdict verdict = map_verdict(report);
  CHECK(has_fault(verdict, "helps only close to its places"));
  CHECK_THAT(verdict.faults[0].fault, Contains("43 mm wide and has no place"));
  CHECK_THAT(verdict.faults[0].remedy, Contains("no such gap stays"));
}

TEST_CASE("A map without uncertainty has a page without that panel") {
  const test::TemporaryFolder folder;
  std::vector<PairRow> pairs;
  FitErrorMapReport report = fitted(test::lens_field, test::kFieldNoise);
  report.result.map = IdwMap{report.result.at_places.positions, report.result.at_places.errors,
                             region_around(report.result.at_places.positions)};
  const std::string page = map_page(view_of(report, ReportList()), folder.write("map.yaml", "\n"));
  check_page(page);
  CHECK_THAT(page, !Contains("How uncertain it is"));
}

TEST_CASE("The page of a field at the lamps draws the end point's error and its pulls") {
  const test::TemporaryFolder folder;
  const test::BentCell cell;
  std::mt19937 random(31);
  const LampFieldFit fit = fit_lamp_field(cell.nominal(), cell.samples(60, 20, random));
  const MapView view = view_of(fit, lamp_field_list(fit));
  CHECK(view.verdict.faults.empty());
  CHECK_THAT(view.verdict.good, Contains("% of it within the stated 95 %"));
  REQUIRE(view.pulls.size() == 120);
  // Taken off where a tool along x is seen, the error drawn there leaves the true end point.
  for (const Eigen::Vector2d& tip : {Eigen::Vector2d(0.3, 0.1), {-0.2, 0.25}, {0.1, -0.35}}) {
    const test::BentCell::Truth truth{tip, 0.0};
    const Eigen::Vector2d seen = tip_from_places({cell.seen(truth, -0.5 * cell.separation),
                                                  cell.seen(truth, 0.5 * cell.separation)},
                                                 cell.nominal().tool)
                                     .p;
    CHECK((seen - tip).norm() > 50e-6);
    CHECK((seen - view.predict(seen).error - tip).norm() < 15e-6);
  }
  const std::string page = map_page(view, folder.write("map.yaml", "format: planar-servo/map/1\n"));
  check_page(page);
  CHECK_THAT(page, Contains("pull, in stated deviations") &&
                       Contains("What was compared at places left out") &&
                       Contains("field without the arm: ") &&
                       Contains("<caption>What each source is worth</caption>") &&
                       Contains("<th scope=\"row\">link 1</th><td>"));
}

TEST_CASE("Where one source alone fixes the turn, its worth is said to leave the turn out") {
  const test::BentCell cell;
  std::mt19937 random(33);
  LampFieldFit fit = fit_lamp_field(cell.nominal(), cell.samples(20, 20, random));
  const auto words = [&] { return lamp_field_list(fit).table_html("sources"); };
  CHECK_THAT(words(), Contains("tracker") && Contains("mm but for the turn"));
  fit.sources.push_back({"marks", "4 of the base", 1e-5});
  CHECK_THAT(words(), !Contains("but for the turn"));
  fit.sources.pop_back();
  fit.fixed_by.turn = FieldSource::kNothing;
  CHECK_THAT(words(), !Contains("but for the turn"));
}

TEST_CASE("Where a map at the end point is taken, report and page are about that map") {
  const test::BentCell cell;
  std::mt19937 random(32);
  LampFieldFit fit = fit_lamp_field(cell.nominal(), cell.samples(20, 20, random));
  CHECK(lamp_field_list(fit).json()["method"] == "lamp_field");
  CHECK_THAT(map_verdict(fit).good, Contains("the end point is known to"));
  const FitErrorMapReport report = fitted(test::lens_field, test::kFieldNoise);
  fit.end_point_map = report.result;
  const ReportList list = lamp_field_list(fit);
  CHECK(list.json()["method"].get<std::string>() == name(kind_of(report.result.map)));
  CHECK(list.table_html("sources").empty());
  CHECK_THAT(map_verdict(fit).good, !Contains("the end point is known to"));
  const MapView view = view_of(fit, list), of_map = view_of(report, list);
  CHECK(view.region.hull == of_map.region.hull);
  CHECK(view.what_is_drawn == of_map.what_is_drawn);
  for (const Eigen::Vector2d& p : of_map.places)
    CHECK(view.predict(p).error == of_map.predict(p).error);
  const test::TemporaryFolder folder;
  LampFieldFiles files{folder.write("pairs.csv", "id\n"), {}, folder / "map.yaml"};
  files.bar = folder.write("bar.csv", "id,x_mm,y_mm,kind,size_mm\n");
  write_lamp_field(files, fit, {}, "test");
  const std::vector<Origin> origins = read_origins(files.map);
  REQUIRE(origins.size() == 2);
  CHECK(origins[1].role == Role::kBar);
}

TEST_CASE("The page of an arm shows places left out over places and angles, and every term") {
  const test::TemporaryFolder folder;
  const test::BentCell cell;
  std::mt19937 random(51);
  std::vector<ArmReading> readings;
  for (const PoseSample& sample : cell.samples(80, 0, random))
    readings.push_back({sample.id, "", sample.motors, *sample.reflector_B, sample.sigma_reflector});
  readings[5].p_B.x() += 0.01;
  const ArmFit fit = fit_arm(cell.nominal(), readings);
  REQUIRE(fit.held_out.size() == 79);
  CHECK(arm_verdict(fit).faults.empty());
  const std::string page = arm_page(fit, folder.write("arm.yaml", "format: planar-servo/arm/1\n"));
  check_page(page);
  CHECK_THAT(page, Contains("Over the angle of motor 3"));
  CHECK_THAT(page, Contains("<th scope=\"row\">link 1</th><td>" +
                            fixed(fit.estimate.fit.arm[0] / kMillimetre, 5)));
  CHECK_THAT(page, Contains("<th scope=\"row\">left out</th><td>" + readings[5].id +
                            ": they contradict the others</td>"));
}

TEST_CASE("An arm is judged by places left out and by what readings leave open") {
  ArmFit fit;
  const test::BentCell cell;
  fit.estimate.nominal = cell.nominal();
  fit.estimate.size = {0, false};
  const ArmModel model = fit.estimate.model();
  fit.estimate.fit.arm = model.nominal();
  fit.estimate.fit.covariance = model.prior_sigma().array().square().matrix().asDiagonal();
  fit.rms = 1e-5;
  fit.held_out_rms = 3e-5;
  fit.held_out.resize(20);
  CHECK(has_fault(arm_verdict(fit), "do not determine link 1, link 2"));
  CHECK(has_fault(arm_verdict(fit), "places left out are met to 0.0300 mm"));
  fit.left_out = {"a", "b"};
  CHECK(has_fault(arm_verdict(fit), "2 of 22 readings contradict"));
}

}  // namespace
}  // namespace planar
