#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "planar_servo/lamps/blob.h"

namespace planar {

/// The outline of a lamp to a small part of a pixel.
struct RimFit {
  Eigen::Vector2d center{0.0, 0.0};
  Eigen::Matrix2d center_covariance{Eigen::Matrix2d::Zero()};
  double diameter{0.0};     ///< of the circle with the ellipse's area
  double blur_px{0.0};      ///< standard deviation; 0 where only half-level edges were measured
  double largest_gap{0.0};  ///< widest angle round the rim that was left out, radians
};

/// Fits an ellipse with a wavy rim to the grey levels along its normals, up to `reach_px` outside
/// it (at most 4.5 px). Departures from an even disc are fitted only as far as the image shows
/// them: levels and slopes that change round the rim (measure_edges), waves (fit_outline),
/// stretches that are not part of the outline (agreeing), clipped pixels. The covariance follows
/// from noise estimated in the image. A rim whose levels do not fit (interlaced or compressed
/// images, lamps of few pixels) is measured by its half-level edges, with the covariance of their
/// scatter. Empty when there is no rim to fit.
std::optional<RimFit> fit_rim(const cv::Mat& image, const Blob& blob, double reach_px);

}  // namespace planar
