#include "planar_servo/report/live_view.h"

#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "support/temporary_folder.h"

namespace planar {
namespace {

using Color = LiveView::Color;
using Shape = LiveView::Shape;

const cv::Rect kPanel(16, 48, kLivePanel_px, kLivePanel_px);

/// A grey frame at (1000, 2000) of the sensor, shown at twice its size, with one lamp measured.
LiveView view_with_lamp_at(const Eigen::Vector2d& uv_px) {
  const int region = kLivePanel_px / 2;
  LiveView view{"a   step 1", cv::Mat(region, region, CV_8UC1, cv::Scalar(128))};
  view.corner_px = {1000.0, 2000.0};
  view.marks = {{uv_px, Shape::kCross, 6.0, Color::kSeen}};
  return view;
}

/// Returns the box about what is drawn in the colour of what was seen, or in smooth letters of it;
/// empty where nothing is.
cv::Rect green_box(const cv::Mat& picture) {
  cv::Mat green;
  cv::inRange(picture, cv::Scalar(0, 120, 0), cv::Scalar(100, 255, 90), green);
  std::vector<cv::Point> places;
  cv::findNonZero(green, places);
  return places.empty() ? cv::Rect() : cv::boundingRect(places);
}

TEST_CASE("A lamp's cross stands where the lamp is in the frame, one off the frame is left out") {
  // A quarter of the way across and half of the way down the panel.
  const cv::Rect cross = green_box(drawn(view_with_lamp_at({1063.5, 2127.5})));
  CHECK(cross == cv::Rect(16 + 128 - 6, 48 + 256 - 6, 13, 13));
  CHECK(green_box(drawn(view_with_lamp_at({999.0, 2127.5}))).empty());
}

TEST_CASE("A frame stands about the part of a picture that no view reaches") {
  LiveView view{"", cv::Mat(400, 800, CV_8UC1, cv::Scalar(128))};
  view.open_px = {{0.0, 0.0, 100.0, 50.0}};
  const cv::Mat picture = drawn(view);
  // The picture is 512 pixels wide in the panel: the lower edge is 32 pixels down.
  const auto is_orange = [&](int y) {
    const auto pixel = picture.at<cv::Vec3b>(kPanel.y + y, kPanel.x + 30);
    return pixel[2] > 2 * pixel[0];
  };
  CHECK((is_orange(31) || is_orange(32)));
  CHECK_FALSE(is_orange(40));
}

TEST_CASE("A view of nothing can be drawn, and a long line is broken") {
  CHECK(drawn(LiveView{}).size() == cv::Size(1000, 580));
  LiveView view;
  view.lines = {{std::string(20, 'a') + " " + std::string(40, 'b'), Color::kSeen}};
  CHECK(green_box(drawn(view)).height > 22);
  CHECK(green_box(drawn(view)).br().x < 1000);
}

TEST_CASE("The picture file shows the newest view, and nothing is left beside it") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "view.png";
  LivePicture live(file);
  for (int i = 0; i < 5; ++i) live.show(view_with_lamp_at({1010.0 + i, 2100.0}));
  const LiveView last = view_with_lamp_at({1200.0, 2200.0});
  live.show(last);
  CHECK(cv::norm(cv::imread(file.string()), drawn(last), cv::NORM_INF) == 0.0);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("A picture that cannot be written does not end the work") {
  LivePicture live("/nowhere/at/all/view.png");
  CHECK_NOTHROW(live.show(view_with_lamp_at({1010.0, 2100.0})));
  CHECK_NOTHROW(live.show(view_with_lamp_at({1010.0, 2100.0})));
}

}  // namespace
}  // namespace planar
