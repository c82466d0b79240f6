#include "planar_servo/report/live_view.h"

#include <visp3/io/vpImageIo.h>

#include <catch2/catch.hpp>

#include "planar_servo/report/view_picture.h"
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
  const ViewPainter painter;
  vpImage<vpRGBa> picture;
  // A quarter of the way across and half of the way down the panel of 512 pixels at (16, 48).
  painter.paint(view_with_lamp_at({1063.5, 2127.5}), picture);
  REQUIRE(picture.getWidth() == kViewWidth);
  REQUIRE(picture.getHeight() == kViewHeight);
  CHECK(is_green(picture[48 + 256][16 + 128]));
  CHECK(green_pixels(picture, 16, 528, 48, 560) == green_pixels(picture, 134, 154, 294, 314));
  painter.paint(view_with_lamp_at({999.0, 2127.5}), picture);
  CHECK(green_pixels(picture, 16, 528, 48, 560) == 0);
}

TEST_CASE("Errors of nothing, of kilometres and without a frame can be drawn") {
  const ViewPainter painter;
  vpImage<vpRGBa> picture;
  ServoView view;
  view.errors_m = {{0.0, 0.0}, {1e6, -1e6}};
  painter.paint(view, picture);
  CHECK(picture.getWidth() == kViewWidth);
}

TEST_CASE("The picture file shows the newest view, however many came before") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "view.png";
  LiveView live(file, false);
  for (int i = 0; i < 50; ++i) live.show(view_with_lamp_at({1010.0 + i, 2100.0}));
  const ServoView last = view_with_lamp_at({1200.0, 2200.0});
  live.show(last);
  CHECK_FALSE(live.close());
  vpImage<vpRGBa> saved, expected;
  vpImageIo::read(saved, file.string());
  ViewPainter().paint(last, expected);
  const bool same = saved == expected;
  CHECK(same);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("A picture that cannot be written is told at the end") {
  LiveView live("/nowhere/at/all/view.png", false);
  live.show(view_with_lamp_at({1010.0, 2100.0}));
  CHECK(live.close());
}

}  // namespace
}  // namespace planar
