#include "planar_servo/lamps/paper/canny_edges.h"

#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace planar {
namespace {

constexpr double kWideDiameter_px = 24.0;  // from here a rim is straight enough for 7 x 7 pixels

// Thresholds of Canny's gradient (Sobel, 4 x a step) and of a step itself, over the lamp's
// contrast: half of a rim blurred by 1 px, and a margin for a lamp that is uneven.
constexpr double kCannyHigh = 1.2, kCannyLow = 0.6, kLeastEdge = 0.3;
constexpr double kRimInside = 0.6, kRimOutside = 1.4;  // of the blob's ellipse

}  // namespace

const GreyMoments& moments_for(const Blob& blob) {
  static const GreyMoments narrow(2), wide(3);
  return blob.diameter_px() < kWideDiameter_px ? narrow : wide;
}

int least_margin_px(const GreyMoments& moments) {
  return static_cast<int>(std::ceil(moments.radius_px())) + 1;
}

std::vector<Eigen::Vector2d> canny_edges(const cv::Mat& image, const Blob& blob) {
  const GreyMoments& moments = moments_for(blob);
  const int margin = least_margin_px(moments);
  const cv::Rect window(blob.box_px.x - margin, blob.box_px.y - margin,
                        blob.box_px.width + 2 * margin, blob.box_px.height + 2 * margin);
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

}  // namespace planar
