#include "planar_servo/offline/locate_lamps.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/offline/lamps_report.h"
#include "support/refused.h"
#include "support/rendered_lamp.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kSeparation_m = 0.1;
constexpr double kDiameter_m = 0.024;
constexpr double kDiameter_px = 20.0;  // of such a lamp from 1.2 m
const cv::Size kSensor(1000, 800);
constexpr double kMeasured_px = 0.15;   // several times the error of one centre
constexpr double kMeasured_m = 0.2e-3;  // the same on the plane, at 833 px/m
constexpr double kDirection = 2.0 * 0.2e-3 / kSeparation_m;

/// A camera that looks down on the plane from 1.2 m.
Workplane workplane() {
  Pose X_WC = Pose::Identity();
  X_WC.linear() = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  X_WC.translation() = Eigen::Vector3d(0.02, -0.01, 1.2);
  return {Pinhole{{1000.0, 1000.0, 500.0, 400.0}}, X_WC};
}

LampScene scene(bool with_workplane) {
  LampScene result;
  result.sensor_px = kSensor;
  result.lamps = {kSeparation_m, {kDiameter_m, kDiameter_m}};
  if (with_workplane) result.vision = VisionCalibration{result.lamps, workplane(), {}};
  return result;
}

/// A folder of rendered frames of the tool at known poses, removed at the end.
class Recording {
 public:
  /// Lamps 1 and 2 of the tool at `tip`, those asked for, in a region of the sensor, the second
  /// larger than the first.
  void add(const TipPose& tip, int lamps = 2, const cv::Rect& region = {{0, 0}, kSensor},
           double second_size = 1.0) {
    const auto lamps_px = *lamps_from_tip(workplane(), {}, kSeparation_m, tip);
    cv::Mat picture = test::background(region.size());
    for (int i = 0; i < lamps; ++i) {
      test::RenderedLamp lamp{lamps_px[static_cast<std::size_t>(i)], kDiameter_px};
      if (i == 1) lamp.diameter_px *= second_size;
      lamp.center_px += moved_px - Eigen::Vector2d(region.x, region.y);
      test::add_lamp(picture, lamp);
    }
    for (const Eigen::Vector2d& place : fixed_px)
      test::add_lamp(picture,
                     {place + moved_px - Eigen::Vector2d(region.x, region.y), kDiameter_px});
    LampImage image;
    image.id = "place_" + std::to_string(images.size());
    image.name = image.id + ".png";
    image.file = folder_ / image.name;
    image.region_px = region;
    image.t_s = t_s;
    image.commanded = tip;
    cv::imwrite(image.file.string(), test::expose(picture, random_));
    images.push_back(image);
    tips.push_back(tip);
  }

  std::vector<LampImage> images;
  std::vector<TipPose> tips;
  // Of the pictures that are added next.
  std::vector<Eigen::Vector2d> fixed_px;  ///< places of fixed lamps
  Eigen::Vector2d moved_px{0.0, 0.0};     ///< of the whole image
  std::optional<double> t_s;

 private:
  test::TemporaryFolder folder_;
  std::mt19937 random_{60};
};

/// Places round the base with the tool turned every way.
void add_places(Recording& recording, int n) {
  for (int i = 0; i < n; ++i) {
    const double angle = 2.4 * i, radius = 0.05 + 0.25 * i / n;
    recording.add({{radius * std::cos(angle), radius * std::sin(angle)}, 1.1 * i});
  }
}

void check_named(const Recording& recording, const std::vector<LampRow>& rows) {
  REQUIRE(rows.size() == recording.tips.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CHECK(rows[i].id == recording.images[i].id);
    REQUIRE(rows[i].status == LampStatus::kOk);
    const auto truth = *lamps_from_tip(workplane(), {}, kSeparation_m, recording.tips[i]);
    CHECK((rows[i].uv_px[0] - truth[0]).norm() < kMeasured_px);
    CHECK((rows[i].uv_px[1] - truth[1]).norm() < kMeasured_px);
  }
}

TEST_CASE("locate_lamps names the lamps by the commanded pose through the workplane") {
  Recording recording;
  add_places(recording, 6);
  recording.add({{0.1, 0.05}, 0.3}, 2, {400, 200, 400, 300});
  const auto rows = locate_lamps({recording.images, scene(true), CenterMethod::kAuto, {}}).rows;
  check_named(recording, rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    REQUIRE((rows[i].p_vision && rows[i].phi && rows[i].sigma));
    CHECK((*rows[i].p_vision - recording.tips[i].p).norm() < kMeasured_m);
    CHECK(std::abs(wrap_angle(*rows[i].phi - recording.tips[i].phi)) < kDirection);
  }
}

TEST_CASE("locate_lamps names the lamps before anything is calibrated, without a position") {
  Recording recording;
  add_places(recording, 12);
  const auto rows = locate_lamps({recording.images, scene(false), CenterMethod::kAuto, {}}).rows;
  check_named(recording, rows);
  for (const LampRow& row : rows) CHECK_FALSE((row.p_vision || row.phi || row.sigma));
}

const std::vector<Eigen::Vector2d> kFixed{
    {60.0, 60.0}, {945.0, 55.0}, {50.0, 745.0}, {940.0, 750.0}};

/// Records with an image that moves by 0.2 px a second, watched by four fixed lamps. Every fourth
/// picture is a whole one, the others are regions.
void record_drift(Recording& recording) {
  recording.fixed_px = kFixed;
  for (int i = 0; i < 13; ++i) {
    recording.t_s = 100.0 + i;
    recording.moved_px = Eigen::Vector2d(0.2 * i, -0.1 * i);
    const double angle = 2.4 * i, radius = 0.02 * i;
    const TipPose tip{{radius * std::cos(angle), radius * std::sin(angle)}, 1.1 * i};
    if (i % 4 == 0)
      recording.add(tip);
    else
      recording.add(tip, 2, {150, 50, 700, 700});
  }
}

LampScene scene_with_fixed_lamps(bool with_workplane) {
  LampScene watched = scene(with_workplane);
  for (const Eigen::Vector2d& place : kFixed)
    watched.reference_lamps.push_back({"at " + std::to_string(static_cast<int>(place.x())),
                                       kDiameter_m, workplane().plane_from_pixel(place)});
  return watched;
}

TEST_CASE("The camera's drift is taken off a recording that shows fixed lamps") {
  Recording recording;
  record_drift(recording);
  const LocateReport report =
      locate_lamps({recording.images, scene_with_fixed_lamps(false), CenterMethod::kAuto, {}});
  check_named(recording, report.rows);
  REQUIRE(report.reference_lamps.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const ReferenceLamp& lamp = report.reference_lamps[i];
    CHECK(lamp.id == "at " + std::to_string(static_cast<int>(kFixed[i].x())));
    CHECK((lamp.uv_px - kFixed[i]).norm() < kMeasured_px);
    CHECK(lamp.sigma_px > 0.0);
  }
  LampScene unwatched = scene(true);
  const auto rows = locate_lamps({recording.images, unwatched, CenterMethod::kAuto, {}}).rows;
  const auto first = (*lamps_from_tip(workplane(), {}, kSeparation_m, recording.tips[12]))[0];
  CHECK((rows[12].uv_px.at(0) - first).norm() > 2.0);
}

TEST_CASE("With a workplane that knows fixed lamps, pixels are as they were for that") {
  Recording recording;
  record_drift(recording);
  LampScene watched = scene_with_fixed_lamps(true);
  const Eigen::Vector2d earlier(-3.0, 4.0);  // the camera stood otherwise then
  for (const Eigen::Vector2d& place : kFixed)
    watched.vision->reference_lamps.push_back({"R", place + earlier, 0.01});
  const LocateReport report = locate_lamps({recording.images, watched, CenterMethod::kAuto, {}});
  for (std::size_t i = 0; i < report.rows.size(); ++i) {
    REQUIRE(report.rows[i].status == LampStatus::kOk);
    const auto truth = *lamps_from_tip(workplane(), {}, kSeparation_m, recording.tips[i]);
    CHECK((report.rows[i].uv_px[0] - truth[0] - earlier).norm() < kMeasured_px);
  }
}

TEST_CASE("Fixed lamps that are not there are missed, and so are whole frames") {
  const auto misses = [](const Recording& recording, const std::string& name) {
    CHECK_THROWS_MATCHES(
        locate_lamps({recording.images, scene_with_fixed_lamps(false), CenterMethod::kAuto, {}}),
        WorkError, Refused(Cause::kInsufficient, name));
  };
  Recording covered;
  covered.fixed_px = {kFixed[0], kFixed[1]};
  Recording regions;
  for (int i = 0; i < 4; ++i) {
    covered.t_s = regions.t_s = i;
    covered.add({{0.05 * i, 0.0}, 0.0});
    regions.add({{0.05 * i, 0.0}, 0.0}, 2, {150, 50, 700, 700});
  }
  misses(covered, "2 lights");
  misses(regions, "0 whole frames");
}

TEST_CASE("locate_lamps is not led astray by a coarse view learned with some lamps missing") {
  Recording recording;
  add_places(recording, 12);
  recording.add({{0.2, 0.1}, 0.0}, 1);
  recording.add({{0.1, 0.2}, 0.0}, 0);
  const auto rows = locate_lamps({recording.images, scene(false), CenterMethod::kAuto, {}}).rows;
  for (std::size_t i = 0; i < 12; ++i) CHECK(rows[i].status == LampStatus::kOk);
  CHECK(rows[12].status == LampStatus::kOneLamp);
  CHECK(rows[13].status == LampStatus::kNoLamp);
}

TEST_CASE("locate_lamps leaves equal lamps ambiguous without a commanded pose") {
  Recording recording;
  recording.add({{0.1, 0.05}, 0.3});
  recording.images[0].commanded.reset();
  LampScene with_plane = scene(true);
  const auto midway = locate_lamps({recording.images, with_plane, CenterMethod::kAuto, {}}).rows[0];
  CHECK(midway.status == LampStatus::kAmbiguous);
  CHECK_FALSE(midway.phi);
  REQUIRE(midway.p_vision);
  CHECK((*midway.p_vision - Eigen::Vector2d(0.1, 0.05)).norm() < kMeasured_m);

  with_plane.vision->tool.p_TP = {0.001, 0.0};  // the end point does not lie midway: no position
  const auto aside = locate_lamps({recording.images, with_plane, CenterMethod::kAuto, {}}).rows[0];
  CHECK(aside.status == LampStatus::kAmbiguous);
  CHECK(aside.uv_px.size() == 2);
  CHECK_FALSE(aside.p_vision);

  with_plane.vision->lamps.separation_m = 1.2 * kSeparation_m;
  const auto wrong = locate_lamps({recording.images, with_plane, CenterMethod::kAuto, {}}).rows[0];
  CHECK(wrong.status == LampStatus::kWrongDistance);
}

TEST_CASE("A separation that is wrong in the cell is named with the measured one") {
  Recording recording;
  add_places(recording, 12);
  const double wrong = GENERATE(0.75 * kSeparation_m, 1e-3 * kSeparation_m);
  const bool calibrated = GENERATE(true, false);
  LampScene other = scene(calibrated);
  other.lamps.separation_m = wrong;
  if (calibrated) other.vision->lamps = other.lamps;
  const LocateReport report = locate_lamps({recording.images, other, CenterMethod::kAuto, {}});
  INFO("separation " << wrong << " m, " << (calibrated ? "with" : "without") << " a workplane");
  REQUIRE(report.wrong_distances.size() == 12);
  CHECK(median(report.wrong_distances) * wrong == Approx(kSeparation_m).epsilon(0.01));
  const Refusal doubt = distance_doubt(report, wrong).value();
  CHECK(doubt.cause == Cause::kContradiction);
  CHECK_THAT(doubt.fault, Catch::Contains("100.0 mm"));
  CHECK_FALSE(distance_doubt({}, wrong));
}

TEST_CASE("locate_lamps tells lamps of different size apart without a commanded pose") {
  constexpr double kLarger = 1.3;
  LampScene with_plane = scene(true);
  with_plane.lamps.diameters_m[1] *= kLarger;
  with_plane.vision->lamps = with_plane.lamps;
  Recording recording;
  for (const double phi : {0.3, 1.9, -2.5})
    recording.add({{0.1, 0.05}, phi}, 2, {{0, 0}, kSensor}, kLarger);
  for (LampImage& image : recording.images) image.commanded.reset();
  const auto report = locate_lamps({recording.images, with_plane, CenterMethod::kAuto, {}});
  for (std::size_t i = 0; i < report.rows.size(); ++i) {
    CHECK(report.rows[i].status == LampStatus::kOk);
    REQUIRE(report.rows[i].phi);
    CHECK(*report.rows[i].phi == Approx(recording.tips[i].phi).margin(kDirection));
  }
}

TEST_CASE("locate_lamps keeps the row of an image that it cannot read or that shows a board") {
  Recording recording;
  for (int i = 0; i < 3; ++i) recording.add({{0.1, 0.05}, 0.3});
  std::ofstream(recording.images[0].file) << "no image";
  recording.images[1].shows_board = true;
  std::filesystem::remove(recording.images[2].file);
  const auto report = locate_lamps({recording.images, scene(true), CenterMethod::kAuto, {}});
  CHECK(report.rows[0].status == LampStatus::kUnreadable);
  CHECK(report.rows[1].status == LampStatus::kBoardView);
  CHECK(report.rows[2].status == LampStatus::kUnreadable);
  CHECK(report.milliseconds.empty());
}

TEST_CASE("locate_lamps names every image of the wrong size") {
  Recording recording;
  for (int i = 0; i < 3; ++i) recording.add({{0.1, 0.05}, 0.3});
  recording.images[0].region_px = cv::Rect(0, 0, 512, 512);
  recording.images[2].region_px.reset();
  LampScene other_sensor = scene(true);
  other_sensor.sensor_px = {5120, 5120};
  const LocateRequest request{recording.images, other_sensor, CenterMethod::kAuto, {}};
  for (const char* name : {"place_0.png", "512 x 512", "place_2.png", "5120 x 5120"})
    CHECK_THROWS_MATCHES(locate_lamps(request), InputError, Refused(Cause::kForeign, name));
}

TEST_CASE("follow_disc gives one lamp per row") {
  Recording recording;
  recording.add({{0.1, 0.05}, 0.0});
  recording.add({{0.105, 0.052}, 0.0});
  const auto truth = *lamps_from_tip(workplane(), {}, kSeparation_m, recording.tips[1]);
  const auto rows =
      follow_disc({recording.images, std::nullopt, CenterMethod::kAuto, {}}, truth[1]).rows;
  REQUIRE(rows.size() == 2);
  REQUIRE(rows[1].status == LampStatus::kOk);
  REQUIRE(rows[1].uv_px.size() == 1);
  CHECK((rows[1].uv_px[0] - truth[1]).norm() < kMeasured_px);
}

}  // namespace
}  // namespace planar
