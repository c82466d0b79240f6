#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "planar_servo/lamps/detect/bright_patch.h"

namespace planar {

/// A bright patch of an image, to the whole pixel: what detection and vpDot2 hand to the
/// measurement of a centre. Pixel coordinates of the image; grey levels 0 to 255.
struct Blob {
  Eigen::Vector2d uv_px{0.0, 0.0};                              ///< centroid
  Eigen::Matrix2d second_moments_px2{Eigen::Matrix2d::Zero()};  ///< central, per unit of area
  double area_px2{0.0};
  cv::Rect box_px;
  double level{0.0};            ///< median of its pixels
  double background{0.0};       ///< median of the pixels round its box
  double saturated_share{0.0};  ///< share of its pixels at 255
  bool touches_border{false};   ///< its box reaches the edge of the image

  double contrast() const { return level - background; }
  /// Of the disc of the same area.
  double diameter_px() const;
  /// Minor over major axis of the ellipse with the same second moments.
  double axis_ratio() const;
  /// Its area over that of this ellipse: 1 for a full ellipse, less for any other shape.
  double fill() const;
};

/// The blob inside `box_px`, from the box's pixels above half way between the background and the
/// level of its pixels above `threshold`. The box must lie in the image and hold such a pixel.
Blob describe_blob(const cv::Mat& image, const cv::Rect& box_px, int threshold);

/// The same of the pixels of some spans in that box only.
Blob describe_blob(const cv::Mat& image, const cv::Rect& box_px, const Span* begin, const Span* end,
                   int threshold);

/// Grey levels by which a lamp stands out; dimmer patches are not told from clutter.
constexpr double kLeastContrast = 20.0;

/// A filled patch that stands out from what surrounds it. The shape of one that the image's edge
/// cuts says nothing.
bool is_filled(const Blob& blob);

/// Filled, and not too long for a disc seen from anywhere but the side.
bool is_lamp_like(const Blob& blob);

/// Throws std::invalid_argument unless the image is CV_8UC1.
void require_8_bit(const cv::Mat& image);

}  // namespace planar
