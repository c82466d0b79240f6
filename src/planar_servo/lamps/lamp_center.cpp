#include "planar_servo/lamps/lamp_center.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "planar_servo/core/units.h"
#include "planar_servo/lamps/paper/grey_moment_edges.h"
#include "planar_servo/lamps/paper/kasa_circle.h"
#include "planar_servo/lamps/rim/edge_noise.h"
#include "planar_servo/lamps/rim/light_centroid.h"
#include "planar_servo/lamps/rim/rim_fit.h"
#include "planar_servo/lamps/visp/vp_dot_tracker.h"

namespace planar {
namespace {

constexpr double kMostSaturated = 0.5;     // share of the lamp's pixels
constexpr double kWideDiameter_px = 24.0;  // from here a rim is straight enough for 7 x 7 pixels
constexpr double kLargestGap = 100.0 * kDegree;
constexpr double kCannySpacing_px = 1.11;  // mean length of a step to a neighbour in 8 directions

// Thresholds of Canny's gradient (Sobel, 4 x a step) and of a step itself, over the lamp's
// contrast: half of a rim blurred by 1 px, and a margin for a lamp that is uneven.
constexpr double kCannyHigh = 1.2, kCannyLow = 0.6, kLeastEdge = 0.3;
constexpr double kRimInside = 0.6, kRimOutside = 1.4;  // of the blob's ellipse

const GreyMoments& window_for(const Blob& blob) {
  static const GreyMoments narrow(2), wide(3);
  return blob.diameter_px() < kWideDiameter_px ? narrow : wide;
}

/// How far apart along the rim, in edges, two windows still share pixels.
int reach(const GreyMoments& moments) {
  return static_cast<int>(std::lround(2.0 * moments.radius_px() / kCannySpacing_px));
}

std::vector<Eigen::Vector2d> rim_edges(const cv::Mat& image, const Blob& blob,
                                       const cv::Rect& window, const GreyMoments& moments) {
  cv::Mat canny;
  cv::Canny(image(window), canny, kCannyLow * blob.contrast(), kCannyHigh * blob.contrast(), 3,
            true);
  const Eigen::Matrix2d shape = (4.0 * blob.second_moments_px2).inverse();
  std::vector<Eigen::Vector2d> edges;
  for (int v = 0; v < canny.rows; ++v) {
    for (int u = 0; u < canny.cols; ++u) {
      if (canny.at<std::uint8_t>(v, u) == 0) continue;
      const cv::Point pixel(window.x + u, window.y + v);
      const Eigen::Vector2d d = Eigen::Vector2d(pixel.x, pixel.y) - blob.uv_px;
      const double radius = std::sqrt(d.dot(shape * d));
      if (radius < kRimInside || radius > kRimOutside) continue;
      const auto edge = moments.edge(image, pixel, kLeastEdge * blob.contrast());
      if (edge) edges.push_back(*edge);
    }
  }
  return edges;
}

/// vpDot2's edges are whole pixels: uniform over one pixel, one per pixel of the rim.
LampCenter at_dot(const VpDot& dot, LampCenter lamp) {
  lamp.status = LampStatus::kOk;
  lamp.uv_px = dot.center_px;
  lamp.covariance_px2 = Eigen::Matrix2d::Identity() / (12.0 * kPi * 0.5 * dot.blob.diameter_px());
  return lamp;
}

LampCenter by_vp_dot(const cv::Mat& image, const Blob& blob, const LampCenter& lamp) {
  const std::optional<VpDot> dot = VpDotTracker().start(image, {0.0, 0.0}, blob);
  return dot ? at_dot(*dot, lamp) : lamp;
}

LampCenter by_kasa(const std::vector<Eigen::Vector2d>& edges, const GreyMoments& moments,
                   LampCenter lamp) {
  constexpr double kParameters = 3.0;
  const std::optional<Circle> circle = kasa_circle(edges);
  if (!circle) return lamp;
  double sum = 0.0;
  std::vector<EdgeResidual> residuals;
  for (const Eigen::Vector2d& p : edges) {
    const Eigen::Vector2d d = p - circle->center;
    residuals.push_back({std::atan2(d.y(), d.x()), d.norm() - circle->radius});
    sum += residuals.back().distance * residuals.back().distance;
  }
  const double shared = edges_per_independent(residuals, reach(moments));
  const double independent = static_cast<double>(edges.size()) / shared;
  if (independent <= kParameters) return lamp;
  const double variance = sum / shared / (independent - kParameters);
  lamp.status = LampStatus::kOk;
  lamp.uv_px = circle->center;
  lamp.covariance_px2 = 2.0 * variance / independent * Eigen::Matrix2d::Identity();
  lamp.diameter_px = 2.0 * circle->radius;
  return lamp;
}

LampCenter by_light(const cv::Mat& image, const Blob& blob, LampCenter lamp) {
  const std::optional<LightCentroid> light = light_centroid(image, blob);
  if (!light) return lamp;
  lamp.status = LampStatus::kOk;
  lamp.uv_px = light->center;
  lamp.covariance_px2 = light->covariance;
  return lamp;
}

LampCenter by_rim(const cv::Mat& image, const Blob& blob, double reach_px, LampCenter lamp) {
  const std::optional<RimFit> rim = fit_rim(image, blob, reach_px);
  if (!rim || rim->largest_gap > kLargestGap) {
    if (blob.saturated_share > kMostSaturated) lamp.status = LampStatus::kSaturated;
    return lamp;
  }
  lamp.status = LampStatus::kOk;
  lamp.uv_px = rim->center;
  lamp.covariance_px2 = rim->center_covariance;
  lamp.diameter_px = rim->diameter;
  return lamp;
}

/// How many pixels lie beyond a box on the side of the image that is nearest to it.
int margin_px(const cv::Size& image, const cv::Rect& box) {
  return std::min({box.x, box.y, image.width - box.br().x, image.height - box.br().y});
}

/// How many pixels must lie beyond a blob's box.
int least_margin_px(const GreyMoments& moments) {
  return static_cast<int>(std::ceil(moments.radius_px())) + 1;
}

/// The lamp before it is measured: kNotRound unless it cannot be measured at all.
LampCenter unmeasured(const cv::Mat& image, const Blob& blob) {
  LampCenter lamp;
  lamp.uv_px = blob.uv_px;
  lamp.diameter_px = blob.diameter_px();
  lamp.status = LampStatus::kNotRound;
  if (margin_px(image.size(), blob.box_px) < least_margin_px(window_for(blob))) {
    lamp.status = LampStatus::kAtBorder;
  } else if (blob.contrast() <= 0.0) {
    lamp.status = LampStatus::kLowContrast;
  }
  return lamp;
}

}  // namespace

LampCenter measure_lamp(const cv::Mat& image, const Blob& blob, CenterMethod method) {
  require_8_bit(image);
  LampCenter lamp = unmeasured(image, blob);
  if (lamp.status != LampStatus::kNotRound) return lamp;
  switch (method) {
    case CenterMethod::kAuto:
      return by_rim(image, blob, margin_px(image.size(), blob.box_px), lamp);
    case CenterMethod::kFast:
      return by_light(image, blob, lamp);
    case CenterMethod::kVpDot2:
      return by_vp_dot(image, blob, lamp);
    case CenterMethod::kCannyKasa:
      break;
  }
  if (blob.saturated_share > kMostSaturated) {
    lamp.status = LampStatus::kSaturated;
    return lamp;
  }
  const GreyMoments& moments = window_for(blob);
  const int margin = least_margin_px(moments);
  const cv::Rect window(blob.box_px.x - margin, blob.box_px.y - margin,
                        blob.box_px.width + 2 * margin, blob.box_px.height + 2 * margin);
  return by_kasa(rim_edges(image, blob, window, moments), moments, lamp);
}

LampCenter lamp_at_dot(const cv::Mat& image, const VpDot& dot) {
  const LampCenter lamp = unmeasured(image, dot.blob);
  return lamp.status == LampStatus::kNotRound ? at_dot(dot, lamp) : lamp;
}

}  // namespace planar
