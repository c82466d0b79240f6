#include "support/rendered_lamp.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace planar::test {
namespace {

/// Adds the lamp's cover of a pixel row, line by line: the length of each line's chord goes to the
/// pixels on it.
void add_chords(const RenderedLamp& lamp, const Eigen::Vector2d& center, int v, cv::Mat& cover) {
  constexpr int kLines = 32;
  const double a = 0.5 * lamp.diameter_px, b = a * lamp.axis_ratio;
  const double c = std::cos(lamp.direction_rad), s = std::sin(lamp.direction_rad);
  // The ellipse is A x^2 + 2 B x y + C y^2 = 1.
  const double A = c * c / (a * a) + s * s / (b * b), C = s * s / (a * a) + c * c / (b * b);
  const double B = c * s * (1.0 / (a * a) - 1.0 / (b * b));
  for (int line = 0; line < kLines; ++line) {
    const double y = v - 0.5 + (line + 0.5) / kLines - center.y();
    const double discriminant = B * B * y * y - A * (C * y * y - 1.0);
    if (discriminant <= 0.0) continue;
    const double begin = center.x() + (-B * y - std::sqrt(discriminant)) / A;
    const double end = center.x() + (-B * y + std::sqrt(discriminant)) / A;
    for (int u = std::max(0, static_cast<int>(begin)); u <= end + 1.0 && u < cover.cols; ++u) {
      const double overlap = std::min(end, u + 0.5) - std::max(begin, u - 0.5);
      cover.at<float>(v, u) += static_cast<float>(std::max(0.0, overlap) / kLines);
    }
  }
}

}  // namespace

cv::Mat background(const cv::Size& size, double level) {
  return cv::Mat(size, CV_32F, cv::Scalar(level));
}

void add_lamp(cv::Mat& scene, const RenderedLamp& lamp) {
  const int half = static_cast<int>(0.5 * lamp.diameter_px + 5.0 * lamp.blur_px) + 3;
  const cv::Point corner(static_cast<int>(std::lround(lamp.center_px.x())) - half,
                         static_cast<int>(std::lround(lamp.center_px.y())) - half);
  cv::Mat cover = cv::Mat::zeros(2 * half + 1, 2 * half + 1, CV_32F);
  const Eigen::Vector2d center = lamp.center_px - Eigen::Vector2d(corner.x, corner.y);
  for (int v = 0; v < cover.rows; ++v) add_chords(lamp, center, v, cover);
  cv::GaussianBlur(cover, cover, cv::Size(), lamp.blur_px, lamp.blur_px);

  const cv::Rect place(corner, cover.size());
  const cv::Rect visible = place & cv::Rect({0, 0}, scene.size());
  if (visible.empty()) return;
  cv::Mat target = scene(visible);
  target += lamp.amplitude * cover(visible - corner);
}

cv::Mat expose(const cv::Mat& scene, std::mt19937& random, const Sensor& sensor) {
  std::normal_distribution<double> normal;
  cv::Mat image(scene.size(), CV_8UC1);
  for (int v = 0; v < scene.rows; ++v) {
    for (int u = 0; u < scene.cols; ++u) {
      const double level = scene.at<float>(v, u);
      const double sigma =
          std::sqrt(level / sensor.gain_e_per_level + sensor.read_noise * sensor.read_noise);
      image.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(level + sigma * normal(random));
    }
  }
  return image;
}

}  // namespace planar::test
