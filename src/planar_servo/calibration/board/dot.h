#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace planar {

/// Describes a round dot as an image shows it: the ellipse {center + shape * (cos t, sin t)}, in
/// pixels.
struct Dot {
  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d shape = Eigen::Matrix2d::Zero();
  /// Standard deviation of the measured centre per axis, from the scatter of the outline.
  double sigma{0.0};

  double area() const;
};

/// Finds all dark blobs of about elliptic outline in an 8-bit grey image, to about half a pixel.
std::vector<Dot> find_dark_dots(const cv::Mat& image);

/// Measures the dot's ellipse to a few hundredths of a pixel. Along rays from its centre it finds
/// where the grey value crosses the middle between dot and surroundings, and fits an ellipse to
/// these places without the outliers among them. Each ray has grey levels of its own, so that
/// shading does not shift the outline. Empty when the image has no such outline there.
std::optional<Dot> measure_dot(const cv::Mat& image, const Dot& rough);

}  // namespace planar
