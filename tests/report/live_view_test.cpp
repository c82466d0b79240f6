#include "planar_servo/report/live/live_view.h"

#include <visp3/core/vpImage.h>
#include <visp3/core/vpRGBa.h>

#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "planar_servo/report/live/live_view.h"
#include "planar_servo/report/live/record_view.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

constexpr int kRegion = 256;  // half the side at which it is shown

/// A grey frame at (1000, 2000) of the sensor, one lamp measured.
ServoView view_with_lamp_at(const Eigen::Vector2d& uv_px) {
  ServoView view;
  view.title = "a   step 1";
  view.frame.image = cv::Mat(kRegion, kRegion, CV_8UC1, cv::Scalar(128));
  view.frame.region_px = {1000, 2000, kRegion, kRegion};
  view.lamps_px = {uv_px};
  view.errors_m = {{1e-3, 0.0}, {1e-5, 2e-5}};
  view.stop_below_m = 2e-5;
  return view;
}

/// In the colour of what was seen.
bool is_green(const vpRGBa& pixel) {
  return pixel.R == 60 && pixel.G == 220 && pixel.B == 90;
}

std::size_t green_pixels(const vpImage<vpRGBa>& picture, unsigned from_x, unsigned to_x,
                         unsigned from_y, unsigned to_y) {
  std::size_t count = 0;
  for (unsigned y = from_y; y < to_y; ++y)
    for (unsigned x = from_x; x < to_x; ++x)
      if (is_green(picture[y][x])) ++count;
  return count;
}

TEST_CASE("A lamp's cross stands where the lamp is in the frame, one off the frame is left out") {
  vpImage<vpRGBa> picture;
  // A quarter of the way across and half of the way down the panel of 512 pixels at (16, 48).
  plot_of(view_with_lamp_at({1063.5, 2127.5}))(picture);
  REQUIRE(picture.getWidth() == kViewWidth);
  REQUIRE(picture.getHeight() == kViewHeight);
  CHECK(is_green(picture[48 + 256][16 + 128]));
  CHECK(green_pixels(picture, 16, 528, 48, 560) == green_pixels(picture, 134, 154, 294, 314));
  plot_of(view_with_lamp_at({999.0, 2127.5}))(picture);
  CHECK(green_pixels(picture, 16, 528, 48, 560) == 0);
}

TEST_CASE("Errors of nothing, of kilometres and without a frame can be drawn") {
  vpImage<vpRGBa> picture;
  ServoView view;
  view.errors_m = {{0.0, 0.0}, {1e6, -1e6}};
  plot_of(view)(picture);
  CHECK(picture.getWidth() == kViewWidth);
}

TEST_CASE("The picture file shows the newest view, however many came before") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "view.png";
  LiveView live(file);
  for (int i = 0; i < 50; ++i) live.show(plot_of(view_with_lamp_at({1010.0 + i, 2100.0})));
  const ServoView last = view_with_lamp_at({1200.0, 2200.0});
  live.show(plot_of(last));
  CHECK_FALSE(live.close());
  vpImage<vpRGBa> expected;
  plot_of(last)(expected);
  cv::Mat saved;
  cv::cvtColor(cv::imread(file.string()), saved, cv::COLOR_BGR2RGBA);
  REQUIRE(saved.size() == cv::Size(kViewWidth, kViewHeight));
  bool same = true;
  for (unsigned i = 0; i < expected.getSize(); ++i) {
    const cv::Vec4b& pixel = saved.at<cv::Vec4b>(static_cast<int>(i));
    same = same && vpRGBa(pixel[0], pixel[1], pixel[2]) == expected.bitmap[i];
  }
  CHECK(same);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("A picture that cannot be written is told at the end") {
  LiveView live("/nowhere/at/all/view.png");
  live.show(plot_of(view_with_lamp_at({1010.0, 2100.0})));
  CHECK(live.close());
}

TEST_CASE("The picture of a board has its dots where they are, green once it stands still") {
  BoardView view;
  view.picture = cv::Mat(400, 800, CV_8UC1, cv::Scalar(128));
  view.dots_px = {{399.5, 199.5}};
  view.open_px = {{0.0, 0.0, 100.0, 50.0}};
  vpImage<vpRGBa> picture;
  plot_of(view)(picture);
  CHECK(green_pixels(picture, 16, 528, 48, 560) == 0);
  view.good = true;
  plot_of(view)(picture);
  // The picture is 512 pixels wide in the panel, and 256 high.
  CHECK(is_green(picture[48 + 128][16 + 256]));
  CHECK(green_pixels(picture, 16, 528, 48, 560) == green_pixels(picture, 262, 282, 166, 186));
  // The lower edge of the open place, 50 pixels down, is orange.
  const auto is_orange = [&](unsigned y) {
    return picture[y][16 + 30].R > 2 * picture[y][16 + 30].B;
  };
  CHECK((is_orange(48 + 31) || is_orange(48 + 32)));
  CHECK_FALSE(is_orange(48 + 40));
}

TEST_CASE("The map of a recording has what is done in green where it is, what is left not") {
  RecordView view;
  view.borders = {{{0.0, 0.0}, 0.5}};
  view.places = {{{0.25, 0.0}, PlaceMark::kDone},
                 {{0.0, 0.25}, PlaceMark::kToDo},
                 {{-0.25, 0.0}, PlaceMark::kLeftOut}};
  vpImage<vpRGBa> picture;
  plot_of(view)(picture);
  // The circle of 0.5 m and a margin of 8 % fill the panel, whose middle is at (272, 304).
  const unsigned quarter = 118;
  CHECK(is_green(picture[304][272 + quarter]));
  CHECK(green_pixels(picture, 16, 528, 48, 560) ==
        green_pixels(picture, 272 + quarter - 4, 272 + quarter + 5, 300, 309));
  CHECK(picture[304][272 - quarter].R > 2 * picture[304][272 - quarter].G);
  view.places[1].mark = PlaceMark::kDone;
  plot_of(view)(picture);
  CHECK(is_green(picture[304 - quarter][272]));
}

TEST_CASE("A map without places, borders and monuments can be drawn") {
  vpImage<vpRGBa> picture;
  plot_of(RecordView{})(picture);
  CHECK(picture.getWidth() == kViewWidth);
}

}  // namespace
}  // namespace planar
