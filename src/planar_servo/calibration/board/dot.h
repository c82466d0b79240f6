#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace planar {

/// A round dot as an image shows it: the ellipse {center + shape * (cos t, sin t)}, in pixels.
struct Dot {
  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d shape = Eigen::Matrix2d::Zero();

  double area() const;
};

/// All dark blobs of about elliptic outline in an 8-bit grey image, to about half a pixel.
std::vector<Dot> find_dark_dots(const cv::Mat& image);

/// The dot's ellipse to a few hundredths of a pixel: along rays from its centre the place where the
/// grey value crosses the middle between dot and surroundings, each ray with levels of its own (so
/// that shading does not pull), and an ellipse fitted to them in which outliers have no part. Empty
/// when the image has no such outline there.
std::optional<Dot> measure_dot(const cv::Mat& image, const Dot& rough);

}  // namespace planar
