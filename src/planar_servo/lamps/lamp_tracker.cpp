#include "planar_servo/lamps/lamp_tracker.h"

#include <algorithm>

#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/lamps/lamp_pair.h"
#include "planar_servo/lamps/visp/vp_dot.h"

namespace planar {
namespace {

// Half the side of a window over the predicted distance of the lamps: the other lamp stays out.
constexpr double kWindowShare = 0.5;
constexpr double kLeastWindow_px = 16.0, kMostWindow_px = 256.0;
constexpr std::size_t kMostCandidates = 32;

/// The expectation in pixels of an image whose first pixel is `origin` on the sensor.
PairExpectation shifted(PairExpectation expectation, const Eigen::Vector2d& origin) {
  if (expectation.predicted_px) {
    for (Eigen::Vector2d& uv : *expectation.predicted_px) uv -= origin;
  }
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
}

void LampTracker::search_image(const cv::Mat& image) {
  const std::vector<Blob>& found = detector_.detect(image);
  const std::size_t n = std::min(found.size(), kMostCandidates);
  candidates_.assign(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n));
}

LampPair LampTracker::measure(const cv::Mat& image, const PairExpectation& expectation) const {
  const PairChoice choice = choose_pair(candidates_, expectation);
  LampPair pair;
  pair.status = choice.status;
  if (pair.status != LampStatus::kOk && pair.status != LampStatus::kAmbiguous) return pair;
  for (std::size_t i : {0u, 1u}) {
    pair.lamps[i] = measure_lamp(image, candidates_[choice.index[i]], method_);
    if (pair.lamps[i].status != LampStatus::kOk) pair.status = pair.lamps[i].status;
  }
  if (!choice.is_unique) pair.lamps[0].status = pair.lamps[1].status = LampStatus::kAmbiguous;
  return pair;
}

LampPair LampTracker::locate(const Frame& frame, const PairExpectation& expectation) {
  require_8_bit(frame.image);
  const Eigen::Vector2d origin(frame.region_px.x, frame.region_px.y);
  const PairExpectation local = shifted(expectation, origin);
  search_windows(frame.image, local);
  LampPair pair = measure(frame.image, local);
  if (pair.status != LampStatus::kOk) {
    search_image(frame.image);
    pair = measure(frame.image, local);
  }
  for (LampCenter& lamp : pair.lamps) lamp.uv_px += origin;
  return pair;
}

}  // namespace planar
