#include "planar_servo/lamps/lamp_tracker.h"

#include <algorithm>

#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/lamps/lamp_pair.h"

namespace planar {
namespace {

// Half the side of a window over the predicted distance of the lamps: the other lamp stays out.
constexpr double kWindowShare = 0.5;
constexpr double kLeastWindow_px = 16.0, kMostWindow_px = 256.0;
constexpr std::size_t kMostCandidates = 32;

/// The first pixel of the frame's image on the sensor.
Eigen::Vector2d corner_of(const Frame& frame) {
  return {frame.region_px.x, frame.region_px.y};
}

/// The expectation in pixels of an image whose first pixel is `origin` on the sensor.
PairExpectation shifted(PairExpectation expectation, const Eigen::Vector2d& origin) {
  if (expectation.predicted_px)
    for (Eigen::Vector2d& uv : *expectation.predicted_px) uv -= origin;
  for (Eigen::Vector2d& uv : expectation.fixed_px) uv -= origin;
  return expectation;
}

}  // namespace

void LampTracker::search_windows(const cv::Mat& image, const PairExpectation& expectation) {
  candidates_.clear();
  if (!expectation.predicted_px) return;
  const auto& [first, second] = *expectation.predicted_px;
  const double half_side =
      std::clamp(kWindowShare * (second - first).norm(), kLeastWindow_px, kMostWindow_px);
  for (const Eigen::Vector2d& place : *expectation.predicted_px) {
    for (const Blob& blob : detector_.detect(image, window_round(place, half_side))) {
      const auto is_same = [&](const Blob& other) { return other.box_px == blob.box_px; };
      if (std::none_of(candidates_.begin(), candidates_.end(), is_same))
        candidates_.push_back(blob);
    }
  }
  drop_fixed(expectation.fixed_px);
}

void LampTracker::search_image(const cv::Mat& image, const PairExpectation& expectation) {
  const std::vector<Blob>& found = detector_.detect(image);
  const std::size_t n = std::min(found.size(), kMostCandidates);
  candidates_.assign(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n));
  drop_fixed(expectation.fixed_px);
}

void LampTracker::drop_fixed(const std::vector<Eigen::Vector2d>& fixed_px) {
  const auto is_fixed = [&](const Blob& blob) {
    return std::any_of(fixed_px.begin(), fixed_px.end(), [&](const Eigen::Vector2d& place) {
      return (blob.uv_px - place).norm() < blob.diameter_px();
    });
  };
  candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), is_fixed),
                    candidates_.end());
}

template <typename Measure>
LampPair LampTracker::choose(const PairExpectation& expectation, const Measure& measure) const {
  const PairChoice choice = choose_pair(candidates_, expectation);
  LampPair pair;
  pair.status = choice.status;
  if (pair.status != LampStatus::kOk && pair.status != LampStatus::kAmbiguous) return pair;
  for (std::size_t i : {0u, 1u}) {
    pair.lamps[i] = measure(i, choice.index[i]);
    if (pair.lamps[i].status != LampStatus::kOk) pair.status = pair.lamps[i].status;
  }
  if (!choice.is_unique) pair.lamps[0].status = pair.lamps[1].status = LampStatus::kAmbiguous;
  return pair;
}

LampPair LampTracker::measure(const Frame& frame, const PairExpectation& expectation) {
  return choose(expectation, [&](std::size_t lamp, std::size_t candidate) {
    const Blob& blob = candidates_[candidate];
    if (method_ == CenterMethod::kVpDot2) dots_[lamp].start(frame.image, corner_of(frame), blob);
    return measure_lamp(frame.image, blob, method_);
  });
}

/// The pair that is followed; without status kOk when a lamp is lost.
LampPair LampTracker::follow(const Frame& frame, const PairExpectation& expectation) {
  candidates_.clear();
  std::vector<VpDot> seen;
  for (VpDotTracker& dot : dots_) {
    const auto lamp = dot.track(frame.image, corner_of(frame));
    if (!lamp || (!seen.empty() && lamp->blob.box_px == seen[0].blob.box_px)) return {};
    seen.push_back(*lamp);
    candidates_.push_back(lamp->blob);
  }
  return choose(expectation, [&](std::size_t, std::size_t candidate) {
    return lamp_at_dot(frame.image, seen[candidate]);
  });
}

LampPair LampTracker::search(const Frame& frame, const PairExpectation& expectation) {
  forget();
  search_windows(frame.image, expectation);
  LampPair pair = measure(frame, expectation);
  if (pair.status != LampStatus::kOk) {
    search_image(frame.image, expectation);
    pair = measure(frame, expectation);
  }
  return pair;
}

LampPair LampTracker::locate(const Frame& frame, const PairExpectation& expectation) {
  require_8_bit(frame.image);
  const PairExpectation local = shifted(expectation, corner_of(frame));
  LampPair pair = follow(frame, local);
  const bool is_unnamed = pair.status == LampStatus::kAmbiguous && !local.predicted_px;
  if (pair.status != LampStatus::kOk && !is_unnamed) pair = search(frame, local);
  for (LampCenter& lamp : pair.lamps) lamp.uv_px += corner_of(frame);
  return pair;
}

void LampTracker::forget() {
  for (VpDotTracker& dot : dots_) dot.forget();
}

}  // namespace planar
