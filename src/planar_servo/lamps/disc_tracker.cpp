#include "planar_servo/lamps/disc_tracker.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/lamps/lamp_center.h"

namespace planar {
namespace {

constexpr double kReach = 3.0;       // diameters that a disc may have moved
constexpr double kRowShare = 0.2;    // of its diameter between two rows that are searched
constexpr double kSizeChange = 1.5;  // most change of its diameter between two images

bool has_size_of(const Blob& blob, const Blob& last) {
  const double ratio = blob.diameter_px() / last.diameter_px();
  return ratio < kSizeChange && ratio > 1.0 / kSizeChange;
}

template <typename Condition>
std::optional<Blob> nearest(const std::vector<Blob>& blobs, const Eigen::Vector2d& place,
                            const Condition& is_possible) {
  std::optional<Blob> best;
  for (const Blob& blob : blobs) {
    if (!is_possible(blob)) continue;
    if (!best || (blob.uv_px - place).norm() < (best->uv_px - place).norm()) best = blob;
  }
  return best;
}

}  // namespace

DiscTracker::DiscTracker(CenterMethod method, std::optional<Eigen::Vector2d> start_px)
    : method_(method), start_px_(std::move(start_px)) {}

/// The patch above half the last contrast that is nearest to the last place.
std::optional<Blob> DiscTracker::find_again(const cv::Mat& image) {
  const double diameter_px = last_->diameter_px();
  const auto threshold = static_cast<int>(std::lround(0.5 * (last_->level + last_->background)));
  const auto most_area = static_cast<int>(kSizeChange * kSizeChange * last_->area_px2);
  const int row_step = std::max(1, static_cast<int>(kRowShare * diameter_px));
  const cv::Rect window =
      window_round(last_->uv_px, kReach * diameter_px) & cv::Rect({0, 0}, image.size());
  patches_.start(image.size());
  found_.clear();
  for (int v = window.y; v < window.br().y; v += row_step) {
    const auto* row = image.ptr<std::uint8_t>(v);
    for (int u = window.x; u < window.br().x; ++u) {
      if (row[u] <= threshold) continue;
      const Span run = run_round(image, v, u, threshold);
      u = run.end;
      if (patches_.is_taken(run.begin, v, 0)) continue;
      const Patch patch = patches_.grow(image, run, threshold, 0, most_area);
      found_.push_back(describe_blob(image, patch.box_px, patches_.begin(patch),
                                     patches_.end(patch), threshold));
    }
  }
  return nearest(found_, last_->uv_px,
                 [&](const Blob& blob) { return is_filled(blob) && has_size_of(blob, *last_); });
}

/// The disc that was picked, or the most evident one.
std::optional<Blob> DiscTracker::find_first(const cv::Mat& image) {
  const std::vector<Blob>& found = detector_.detect(image);
  if (!start_px_) return found.empty() ? std::nullopt : std::optional<Blob>(found.front());
  const cv::Point start(static_cast<int>(start_px_->x()), static_cast<int>(start_px_->y()));
  return nearest(found, *start_px_, [&](const Blob& blob) { return start.inside(blob.box_px); });
}

LampCenter DiscTracker::locate(const cv::Mat& image) {
  require_8_bit(image);
  if (const auto seen = dot_.track(image, {0.0, 0.0})) {
    last_ = seen->blob;
    return lamp_at_dot(image, *seen);
  }
  const std::optional<Blob> blob = last_ ? find_again(image) : find_first(image);
  if (!blob) return {};
  last_ = blob;
  if (method_ == CenterMethod::kVpDot2) dot_.start(image, {0.0, 0.0}, *blob);
  return measure_lamp(image, *blob, method_);
}

}  // namespace planar
