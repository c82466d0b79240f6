#include "planar_servo/lamps/lamp_tracker.h"

#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "support/rendered_lamp.h"
#include "support/shared_data.h"

namespace planar {
namespace {

cv::Mat image_with(const std::vector<Eigen::Vector2d>& discs) {
  std::mt19937 random(40);
  cv::Mat scene = test::background({400, 300});
  for (const Eigen::Vector2d& center : discs) test::add_lamp(scene, {center});
  return test::expose(scene, random);
}

TEST_CASE("DiscTracker follows the disc it was started on, over small steps and a jump") {
  DiscTracker tracker(CenterMethod::kAuto, Eigen::Vector2d(300, 200));
  constexpr double kMeasured_px = 0.12;
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(301, 199), Eigen::Vector2d(290, 190),
                                       Eigen::Vector2d(280.5, 180.5), Eigen::Vector2d(240, 120)}) {
    const LampCenter disc = tracker.locate(image_with({{60, 60}, place}));
    REQUIRE(disc.status == LampStatus::kOk);
    CHECK((disc.uv_px - place).norm() < kMeasured_px);
  }
}

TEST_CASE("DiscTracker follows a disc by vpDot2 over small steps, a jump and a loss") {
  DiscTracker tracker(CenterMethod::kVpDot2, Eigen::Vector2d(300, 200));
  constexpr double kMeasured_px = 0.16;  // four times vpDot2's error of 0.04 px
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(301, 199), Eigen::Vector2d(290, 190),
                                       Eigen::Vector2d(280.5, 180.5), Eigen::Vector2d(240, 120)}) {
    const LampCenter disc = tracker.locate(image_with({{60, 60}, place}));
    REQUIRE(disc.status == LampStatus::kOk);
    CHECK((disc.uv_px - place).norm() < kMeasured_px);
  }
  CHECK(tracker.locate(image_with({{60, 60}})).status == LampStatus::kNoLamp);
  CHECK(tracker.locate(image_with({{60, 60}, {241, 121}})).status == LampStatus::kOk);
}

TEST_CASE("DiscTracker says no_lamp while the disc is away and finds it again") {
  DiscTracker tracker(CenterMethod::kAuto);
  CHECK(tracker.locate(image_with({})).status == LampStatus::kNoLamp);
  CHECK(tracker.locate(image_with({{200, 150}})).status == LampStatus::kOk);
  CHECK(tracker.locate(image_with({})).status == LampStatus::kNoLamp);
  CHECK(tracker.locate(image_with({{210, 160}})).status == LampStatus::kOk);
  CHECK(tracker.locate(cv::Mat()).status == LampStatus::kNoLamp);
}

TEST_CASE("DiscTracker has a status for every frame of a disc that is partly out of view") {
  const auto folder = test::visp_image("ellipse-1");
  if (!folder) return;
  DiscTracker tracker(CenterMethod::kAuto);
  int at_border = 0;
  for (int i = 1; i <= 50; ++i) {
    const auto file = *folder / fmt::format("image.{:04}.pgm", i);
    const LampCenter disc = tracker.locate(cv::imread(file.string(), cv::IMREAD_GRAYSCALE));
    at_border += disc.status == LampStatus::kAtBorder ? 1 : 0;
  }
  CHECK(at_border == 50);
}

TEST_CASE("DiscTracker moves little, or says at_border, when photographs are cropped by a pixel") {
  const auto folder = test::visp_image("ellipse-1");
  if (!folder) return;
  constexpr double kCropped_px = 0.5;
  for (int i = 1; i <= 50; i += 7) {
    const auto file = *folder / fmt::format("image.{:04}.pgm", i);
    const cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    const LampCenter whole = DiscTracker(CenterMethod::kAuto).locate(image);
    for (const cv::Rect& crop :
         {cv::Rect(1, 0, image.cols - 1, image.rows), cv::Rect(0, 0, image.cols - 1, image.rows),
          cv::Rect(0, 1, image.cols, image.rows - 1), cv::Rect(0, 0, image.cols, image.rows - 1)}) {
      const LampCenter cropped = DiscTracker(CenterMethod::kAuto).locate(image(crop));
      if (cropped.status == LampStatus::kAtBorder) continue;
      CHECK(cropped.status == whole.status);
      const Eigen::Vector2d moved = cropped.uv_px + Eigen::Vector2d(crop.x, crop.y) - whole.uv_px;
      CHECK(moved.norm() < kCropped_px);
    }
  }
}

TEST_CASE("DiscTracker measures a disc with a notch correctly, or says that it cannot") {
  const auto path = test::visp_image("circle/circle.pgm");
  if (!path) return;
  const cv::Mat image = cv::imread(path->string(), cv::IMREAD_GRAYSCALE);
  constexpr double kByHand_px = 0.5;
  const LampCenter disc = DiscTracker(CenterMethod::kAuto).locate(image);
  CAPTURE(name(disc.status), disc.uv_px.transpose());
  if (disc.status == LampStatus::kOk) {
    CHECK((disc.uv_px - Eigen::Vector2d(155.5, 110.5)).norm() < kByHand_px);
  } else {
    CHECK(disc.status != LampStatus::kNoLamp);  // seen and refused, not overlooked
  }
}

TEST_CASE("DiscTracker follows each of five discs through 501 photographs without a swap") {
  const auto folder = test::visp_image("mire-2");
  if (!folder) return;
  std::vector<Eigen::Vector2d> last{{86, 180}, {216, 168}, {93, 267}, {243, 248}, {159, 213}};
  std::vector<DiscTracker> trackers;
  for (const Eigen::Vector2d& start : last) trackers.emplace_back(CenterMethod::kAuto, start);
  std::map<std::string, int> statuses;
  double largest_step = 0.0, least_distance = 1e9;
  for (int i = 1; i <= 501; ++i) {
    const auto file = *folder / fmt::format("image.{:04}.pgm", i);
    const cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    for (std::size_t k = 0; k < trackers.size(); ++k) {
      const LampCenter disc = trackers[k].locate(image);
      ++statuses[name(disc.status)];
      if (disc.status == LampStatus::kNoLamp) continue;
      largest_step = std::max(largest_step, (disc.uv_px - last[k]).norm());
      last[k] = disc.uv_px;
      for (std::size_t j = 0; j < k; ++j)
        least_distance = std::min(least_distance, (last[k] - last[j]).norm());
    }
  }
  for (const auto& [status, count] : statuses) UNSCOPED_INFO(status << " " << count);
  CAPTURE(largest_step, least_distance);
  // The narrowest are 10 px wide and 5 px high, in interlaced frames: not every one is measured.
  CHECK(statuses["ok"] + statuses["not_round"] == 5 * 501);
  CHECK(statuses["ok"] > 0.98 * 5 * 501);
  CHECK(largest_step < 0.5 * least_distance);  // no disc came near another's last place
}

}  // namespace
}  // namespace planar
