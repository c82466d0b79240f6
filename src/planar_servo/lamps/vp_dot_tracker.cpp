#include "planar_servo/lamps/vp_dot_tracker.h"

#include <visp3/blob/vpDot2.h>

#include <algorithm>
#include <cmath>

namespace planar {
namespace {

constexpr int kLeastSide_px = 3;  // of a window, and of a blob
// Half the side of the patch over the blob's size. vpDot2 searches a square of 5 times its size.
constexpr double kDotReach = 3.0;

vpImage<unsigned char> visp_image(const cv::Mat& patch) {
  vpImage<unsigned char> image(static_cast<unsigned>(patch.rows),
                               static_cast<unsigned>(patch.cols));
  for (int v = 0; v < patch.rows; ++v)
    std::copy_n(patch.ptr<std::uint8_t>(v), patch.cols, image[static_cast<unsigned>(v)]);
  return image;
}

int level_between(const Blob& blob) {
  return std::clamp(static_cast<int>(std::lround(0.5 * (blob.level + blob.background))), 1, 255);
}

int size_of(const Blob& blob) {
  return std::max(blob.box_px.width, blob.box_px.height);
}

/// Returns what vpDot2 sees in the window of the image. Empty when that is too small for a blob.
std::optional<VpDot> seen_by(const vpDot2& dot, const cv::Mat& image, const cv::Rect& window,
                             int level) {
  const vpRect bounds = dot.getBBox();
  const cv::Rect box(window.x + static_cast<int>(bounds.getLeft()),
                     window.y + static_cast<int>(bounds.getTop()),
                     static_cast<int>(bounds.getWidth()), static_cast<int>(bounds.getHeight()));
  const cv::Rect box_in_window = box & window;
  if (std::min(box_in_window.width, box_in_window.height) < kLeastSide_px) return std::nullopt;
  return VpDot{{window.x + dot.getCog().get_u(), window.y + dot.getCog().get_v()},
               describe_blob(image, box_in_window, level - 1)};
}

}  // namespace

VpDotTracker::VpDotTracker() = default;
VpDotTracker::VpDotTracker(VpDotTracker&&) noexcept = default;
VpDotTracker& VpDotTracker::operator=(VpDotTracker&&) noexcept = default;
VpDotTracker::~VpDotTracker() = default;

std::optional<VpDot> VpDotTracker::start(const cv::Mat& image, const Eigen::Vector2d& corner_px,
                                         const Blob& blob) {
  dot_ = std::make_unique<vpDot2>();
  dot_->setEllipsoidShapePrecision(0.0);  // the shape is judged by is_lamp_like()
  place_px_ = blob.uv_px + corner_px;
  level_ = level_between(blob);
  size_px_ = size_of(blob);
  return look(image, corner_px, 1.0, [&](const vpImage<unsigned char>& patch, vpImagePoint place) {
    place.set_uv(std::round(place.get_u()), std::round(place.get_v()));
    dot_->initTracking(patch, place, static_cast<unsigned>(level_), 255u);
  });
}

std::optional<VpDot> VpDotTracker::track(const cv::Mat& image, const Eigen::Vector2d& corner_px) {
  if (!dot_) return std::nullopt;
  return look(image, corner_px, kDotReach,
              [&](const vpImage<unsigned char>& patch, vpImagePoint place) {
                // vpDot2 would take levels about the blob's mean instead.
                dot_->setGrayLevelMin(static_cast<unsigned>(level_));
                dot_->setGrayLevelMax(255u);
                dot_->setCog(place);
                dot_->track(patch);
              });
}

template <typename Action>
std::optional<VpDot> VpDotTracker::look(const cv::Mat& image, const Eigen::Vector2d& corner_px,
                                        double reach, const Action& action) {
  const Eigen::Vector2d place = place_px_ - corner_px;
  const cv::Rect window = window_round(place, reach * size_px_) & cv::Rect({0, 0}, image.size());
  std::optional<VpDot> seen;
  if (std::min(window.width, window.height) >= kLeastSide_px &&
      window.contains(
          {static_cast<int>(std::lround(place.x())), static_cast<int>(std::lround(place.y()))})) {
    try {
      action(visp_image(image(window)), {place.y() - window.y, place.x() - window.x});
      seen = seen_by(*dot_, image, window, level_);
    } catch (const vpException&) {  // how vpDot2 says that there is no blob
    }
  }
  if (!seen) {
    forget();
    return std::nullopt;
  }
  place_px_ = seen->center_px + corner_px;
  level_ = level_between(seen->blob);
  size_px_ = size_of(seen->blob);
  return seen;
}

void VpDotTracker::forget() {
  dot_.reset();
}

cv::Rect window_round(const Eigen::Vector2d& uv_px, double half_side_px) {
  const int half = static_cast<int>(std::ceil(half_side_px));
  return {static_cast<int>(std::lround(uv_px.x())) - half,
          static_cast<int>(std::lround(uv_px.y())) - half, 2 * half + 1, 2 * half + 1};
}

}  // namespace planar
