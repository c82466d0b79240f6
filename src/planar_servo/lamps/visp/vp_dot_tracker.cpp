#include "planar_servo/lamps/visp/vp_dot.h"

#include <visp3/blob/vpDot2.h>

#include <algorithm>
#include <cmath>

namespace planar {
namespace {

constexpr int kLeastSide_px = 3;  // of a window, and of a blob

vpImage<unsigned char> visp_image(const cv::Mat& patch) {
  vpImage<unsigned char> image(static_cast<unsigned>(patch.rows),
                               static_cast<unsigned>(patch.cols));
  for (int v = 0; v < patch.rows; ++v) {
    std::copy_n(patch.ptr<std::uint8_t>(v), patch.cols, image[static_cast<unsigned>(v)]);
  }
  return image;
}

}  // namespace

std::optional<VpDot> vp_dot(const cv::Mat& image, const cv::Rect& window_px,
                            const Eigen::Vector2d& seed_px, int least_level) {
  const cv::Rect window = window_px & cv::Rect({0, 0}, image.size());
  const cv::Point seed(static_cast<int>(std::lround(seed_px.x())),
                       static_cast<int>(std::lround(seed_px.y())));
  if (std::min(window.width, window.height) < kLeastSide_px || !window.contains(seed)) return {};

  const vpImage<unsigned char> patch = visp_image(image(window));
  vpDot2 dot;
  dot.setEllipsoidShapePrecision(0.0);  // the shape is judged by is_lamp_like()
  try {
    dot.initTracking(patch, vpImagePoint(seed.y - window.y, seed.x - window.x),
                     static_cast<unsigned>(std::clamp(least_level, 1, 255)), 255u);
  } catch (const vpException&) {  // how vpDot2 says that there is no blob
    return {};
  }
  const vpRect bounds = dot.getBBox();
  const cv::Rect box(window.x + static_cast<int>(bounds.getLeft()),
                     window.y + static_cast<int>(bounds.getTop()),
                     static_cast<int>(bounds.getWidth()), static_cast<int>(bounds.getHeight()));
  const cv::Rect box_in_window = box & window;
  if (std::min(box_in_window.width, box_in_window.height) < kLeastSide_px) return {};
  return VpDot{{window.x + dot.getCog().get_u(), window.y + dot.getCog().get_v()},
               describe_blob(image, box_in_window, least_level - 1)};
}

cv::Rect window_round(const Eigen::Vector2d& uv_px, double half_side_px) {
  const int half = static_cast<int>(std::ceil(half_side_px));
  return {static_cast<int>(std::lround(uv_px.x())) - half,
          static_cast<int>(std::lround(uv_px.y())) - half, 2 * half + 1, 2 * half + 1};
}

}  // namespace planar
