#include "support/cramer_rao.h"

#include <Eigen/LU>
#include <array>
#include <cmath>

namespace planar::bench {
namespace {

constexpr int kUnknowns = 7;
constexpr double kStep = 0.02;  // pixels or grey levels, of the central differences

using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;

/// With these changes of the centre; of the axes (a symmetric deformation: along u, along v,
/// oblique, each in pixels of the radius); of the background; of the amplitude.
cv::Mat scene(test::RenderedLamp lamp, double background, const Unknowns& change) {
  const double radius = 0.5 * lamp.diameter_px, c = std::cos(lamp.direction_rad),
               s = std::sin(lamp.direction_rad);
  Eigen::Matrix2d turn, deform;
  turn << c, -s, s, c;
  deform << 1.0 + change[2] / radius, change[4] / radius, change[4] / radius,
      1.0 + change[3] / radius;
  const Eigen::Matrix2d axes =
      deform * turn * Eigen::Vector2d(radius, radius * lamp.axis_ratio).asDiagonal();
  const Eigen::Matrix2d moments = axes * axes.transpose();
  const double mean = 0.5 * moments.trace();
  const double half = 0.5 * (moments(0, 0) - moments(1, 1));
  const double spread = std::hypot(half, moments(0, 1));
  lamp.center_px += change.head<2>();
  lamp.diameter_px = 2.0 * std::sqrt(mean + spread);
  lamp.axis_ratio = std::sqrt((mean - spread) / (mean + spread));
  lamp.direction_rad = 0.5 * std::atan2(moments(0, 1), half);
  lamp.amplitude += change[6];
  cv::Mat image = test::background({128, 128}, background + change[5]);
  test::add_lamp(image, lamp);
  return image;
}

}  // namespace

double cramer_rao_px(const test::RenderedLamp& lamp, double background,
                     const test::Sensor& sensor) {
  constexpr double kRounding = 1.0 / 12.0, kClipped = 255.0;
  const cv::Mat truth = scene(lamp, background, Unknowns::Zero());
  std::array<cv::Mat, kUnknowns> slopes;
  for (int i = 0; i < kUnknowns; ++i) {
    const Unknowns step = kStep * Unknowns::Unit(i);
    slopes[static_cast<std::size_t>(i)] =
        (scene(lamp, background, step) - scene(lamp, background, -step)) / (2.0 * kStep);
  }
  Eigen::Matrix<double, kUnknowns, kUnknowns> information;
  information.setZero();
  for (int v = 0; v < truth.rows; ++v) {
    for (int u = 0; u < truth.cols; ++u) {
      const double level = truth.at<float>(v, u);
      if (level >= kClipped) continue;
      Unknowns slope;
      for (int i = 0; i < kUnknowns; ++i) {
        slope[i] = slopes[static_cast<std::size_t>(i)].at<float>(v, u);
      }
      information +=
          slope * slope.transpose() /
          (level / sensor.gain_e_per_level + sensor.read_noise * sensor.read_noise + kRounding);
    }
  }
  return std::sqrt(0.5 * information.inverse().topLeftCorner<2, 2>().trace());
}

}  // namespace planar::bench
