#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "planar_servo/lamps/detect/bright_patch.h"

namespace planar {

/// Describes a bright patch to the whole pixel. Detection and vpDot2 produce it, and the
/// measurement of a centre starts from it. Pixel coordinates of the image; grey levels 0 to 255.
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
  /// Returns the diameter of the disc of the same area.
  double diameter_px() const;
  /// Returns the ratio of minor to major axis of the ellipse with the same second moments.
  double axis_ratio() const;
  /// Returns the area divided by that of this ellipse: 1 for a full ellipse, less for other shapes.
  double fill() const;
};

/// Describes the blob inside `box_px`: the box's pixels above half way between the background and
/// the level of its pixels above `threshold`. The box must lie in the image and hold such a pixel.
Blob describe_blob(const cv::Mat& image, const cv::Rect& box_px, int threshold);

/// Describes the blob that the spans hold inside `box_px`; other pixels of the box are left out.
Blob describe_blob(const cv::Mat& image, const cv::Rect& box_px, const Span* begin, const Span* end,
                   int threshold);

/// The least contrast of a lamp, in grey levels. Dimmer patches cannot be told from clutter.
constexpr double kLeastContrast = 20.0;

/// Returns whether the patch stands out and is full. A patch cut by the image's edge passes,
/// because its shape says nothing.
bool is_filled(const Blob& blob);

/// Returns whether the blob is full and round enough for a disc that is not seen from the side.
bool is_lamp_like(const Blob& blob);

/// Throws std::invalid_argument unless the image is CV_8UC1.
void require_8_bit(const cv::Mat& image);

}  // namespace planar
