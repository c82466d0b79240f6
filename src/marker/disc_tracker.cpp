#include "marker/disc_tracker.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "marker/lamp_center.h"
#include "marker/vp_dot.h"

namespace planar {
namespace {

constexpr double kReach = 3.0;       // diameters that a lost disc may have moved
constexpr double kSizeChange = 1.5;  // most change of its diameter between two images

bool has_size_of(const Blob& blob, const Blob& last) {
  const double ratio = blob.diameter_px() / last.diameter_px();
  return ratio < kSizeChange && ratio > 1.0 / kSizeChange;
}

std::optional<Blob> follow(const cv::Mat& image, const Blob& last) {
  const auto level = static_cast<int>(std::lround(0.5 * (last.level + last.background)));
  const double size = std::max(last.box_px.width, last.box_px.height);
  const std::optional<VpDot> dot =
      vp_dot(image, window_round(last.uv_px, 2.0 * size), last.uv_px, level);
  if (!dot || !is_filled(dot->blob) || !has_size_of(dot->blob, last)) return std::nullopt;
  return dot->blob;
}

}  // namespace

DiscTracker::DiscTracker(CenterMethod method, std::optional<Eigen::Vector2d> start_px)
    : method_(method), start_px_(std::move(start_px)) {}

std::optional<Blob> DiscTracker::find(const cv::Mat& image) {
  if (last_) {
    const std::optional<Blob> followed = follow(image, *last_);
    if (followed) return followed;
  }
  std::vector<Blob> candidates = detector_.detect(image);
  const auto is_elsewhere = [&](const Blob& blob) {
    if (last_) {
      return !has_size_of(blob, *last_) ||
             (blob.uv_px - last_->uv_px).norm() > kReach * last_->diameter_px();
    }
    return start_px_ && !blob.box_px.contains(cv::Point(static_cast<int>(start_px_->x()),
                                                        static_cast<int>(start_px_->y())));
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), is_elsewhere),
                   candidates.end());
  if (candidates.empty()) return std::nullopt;
  if (!last_ && !start_px_) return candidates.front();
  const Eigen::Vector2d place = last_ ? last_->uv_px : *start_px_;
  return *std::min_element(candidates.begin(), candidates.end(), [&](const Blob& a, const Blob& b) {
    return (a.uv_px - place).norm() < (b.uv_px - place).norm();
  });
}

LampCenter DiscTracker::locate(const cv::Mat& image) {
  require_8_bit(image);
  const std::optional<Blob> blob = find(image);
  if (!blob) return {};
  last_ = blob;
  return measure_lamp(image, *blob, method_);
}

}  // namespace planar
