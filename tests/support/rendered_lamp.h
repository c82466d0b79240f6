#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <random>

namespace planar::test {

/// A lamp that is a uniform, blurred ellipse. Its coverage of pixels is exact.
struct RenderedLamp {
  Eigen::Vector2d center_px{0.0, 0.0};
  double diameter_px{40.0};  ///< length of the major axis
  double axis_ratio{1.0};
  double direction_rad{0.0};  ///< direction of the major axis, from u to v
  double amplitude{180.0};    ///< grey levels above the background
  double blur_px{0.85};       ///< standard deviation of the blur
};

/// Returns a noise-free scene of CV_32F grey levels.
cv::Mat background(const cv::Size& size, double level = 12.0);
/// Adds the lamp's light to a scene.
void add_lamp(cv::Mat& scene, const RenderedLamp& lamp);

/// The noise of a sensor.
struct Sensor {
  double gain_e_per_level{18.6};
  double read_noise{0.5};  ///< grey levels
};

/// Returns the scene with shot and read noise, rounded to 8 bits.
cv::Mat expose(const cv::Mat& scene, std::mt19937& random, const Sensor& sensor = {});

}  // namespace planar::test
