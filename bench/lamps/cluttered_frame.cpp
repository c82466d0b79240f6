#include "lamps/cluttered_frame.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "planar_servo/base/core/units.h"

namespace planar::bench {
namespace {

constexpr int kSide_px = 5120;
constexpr double kDark = 12.0;
constexpr int kSpeckShapes = 512;
constexpr double kThirdLightOff = 0.1;  // least share by which the third light's distance is wrong

/// Makes the dark frame by OpenCV's generator: 26 million values are too many for expose().
cv::Mat dark_frame(unsigned seed) {
  const test::Sensor sensor;
  const double sigma =
      std::sqrt(kDark / sensor.gain_e_per_level + sensor.read_noise * sensor.read_noise);
  cv::RNG random(seed);
  cv::Mat level(kSide_px, kSide_px, CV_32F), frame;
  random.fill(level, cv::RNG::NORMAL, kDark, sigma);
  level.convertTo(frame, CV_8U);
  return frame;
}

/// Returns the light of a lamp alone, and the corner of its box.
std::pair<cv::Mat, cv::Point> light_of(test::RenderedLamp lamp) {
  const int half = static_cast<int>(0.5 * lamp.diameter_px + 5.0 * lamp.blur_px) + 2;
  const cv::Point corner(static_cast<int>(lamp.center_px.x()) - half,
                         static_cast<int>(lamp.center_px.y()) - half);
  lamp.center_px -= Eigen::Vector2d(corner.x, corner.y);
  cv::Mat light = test::background({2 * half, 2 * half}, 0.0);
  test::add_lamp(light, lamp);
  return {light, corner};
}

}  // namespace

ClutteredFrame::ClutteredFrame(unsigned seed)
    : random_(seed), dark_(dark_frame(seed)), image_(dark_.clone()) {
  for (int i = 0; i < kSpeckShapes; ++i) {
    test::RenderedLamp speck;
    speck.center_px = {uniform(50.0, 51.0), uniform(50.0, 51.0)};
    speck.diameter_px = uniform(1.0, 6.0);
    speck.axis_ratio = uniform(0.5, 1.0);
    speck.direction_rad = uniform(0.0, kPi);
    speck.amplitude = uniform(60.0, 400.0);
    speck_light_.push_back(light_of(speck).first);
  }
}

double ClutteredFrame::separation_px() const {
  return (lamps_[1].center_px - lamps_[0].center_px).norm();
}

double ClutteredFrame::uniform(double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random_);
}

Eigen::Vector2d ClutteredFrame::draw_place(double margin_px) {
  const double u = uniform(margin_px, kSide_px - margin_px);
  return {u, uniform(margin_px, kSide_px - margin_px)};
}

void ClutteredFrame::restore() {
  for (const cv::Rect& box : touched_) dark_(box).copyTo(image_(box));
  touched_.clear();
}

/// Adds light with its own shot noise to what is there.
void ClutteredFrame::add(const cv::Mat& light, const cv::Point& corner) {
  const cv::Rect place(corner, light.size());
  const cv::Rect visible = place & cv::Rect({0, 0}, image_.size());
  if (visible.empty()) return;
  touched_.push_back(visible);
  test::Sensor without_reading;
  without_reading.read_noise = 0.0;
  cv::Mat target = image_(visible);
  cv::add(target, test::expose(light(visible - corner), random_, without_reading), target);
}

void ClutteredFrame::add_lamp(const test::RenderedLamp& lamp) {
  const auto [light, corner] = light_of(lamp);
  add(light, corner);
}

void ClutteredFrame::add_specks(int count) {
  std::uniform_int_distribution<std::size_t> shape(0, speck_light_.size() - 1);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d place = draw_place(0.0);
    add(speck_light_[shape(random_)], {static_cast<int>(place.x()), static_cast<int>(place.y())});
  }
}

/// Adds a line of light, up to 5 px wide and 600 px long.
void ClutteredFrame::add_streak() {
  const int side = static_cast<int>(uniform(200.0, 600.0));
  cv::Mat light = test::background({side, side}, 0.0);
  const double end = uniform(0.0, side);
  cv::line(light, {0, static_cast<int>(uniform(0.0, side))}, {side - 1, static_cast<int>(end)},
           cv::Scalar(uniform(60.0, 240.0)), static_cast<int>(uniform(1.0, 6.0)), cv::LINE_AA);
  const Eigen::Vector2d place = draw_place(300.0);
  add(light, {static_cast<int>(place.x()), static_cast<int>(place.y())});
}

/// Adds a long, soft patch of dim light.
void ClutteredFrame::add_reflection() {
  test::RenderedLamp patch{draw_place(300.0)};
  patch.diameter_px = uniform(80.0, 250.0);
  patch.axis_ratio = uniform(0.1, 0.25);
  patch.direction_rad = uniform(0.0, kPi);
  patch.amplitude = uniform(15.0, 60.0);
  patch.blur_px = 2.0;
  add_lamp(patch);
}

void ClutteredFrame::draw(const FrameKind& kind) {
  constexpr double kMargin_px = 100.0;
  restore();
  third_lamp_.reset();
  test::RenderedLamp lamp;
  lamp.blur_px = uniform(0.7, 1.0);
  if (kind.any_lamp) {
    lamp.diameter_px = std::exp(uniform(std::log(12.0), std::log(120.0)));
    lamp.amplitude = uniform(40.0, 400.0);
  }
  const double apart = uniform(3.0, 8.0) * lamp.diameter_px;
  const double turn = uniform(0.0, 2.0 * kPi);
  lamps_ = {lamp, lamp};
  lamps_[0].center_px = draw_place(kMargin_px + apart);
  lamps_[1].center_px =
      lamps_[0].center_px + apart * Eigen::Vector2d(std::cos(turn), std::sin(turn));
  for (const test::RenderedLamp& each : lamps_) add_lamp(each);
  if (kind.other_lights) {
    for (int i = 0; i < 4; ++i) add_streak();
    for (int i = 0; i < 4; ++i) add_reflection();
    const auto passes = [&](const test::RenderedLamp& each) {
      const double distance = (each.center_px - lamp.center_px).norm();
      return std::abs(distance / apart - 1.0) < kThirdLightOff || distance < 2.0 * lamp.diameter_px;
    };
    do {
      lamp.center_px = draw_place(kMargin_px);
    } while (passes(lamps_[0]) || passes(lamps_[1]));
    third_lamp_ = lamp;
    add_lamp(lamp);
  }
  add_specks(kind.specks);
}

}  // namespace planar::bench
