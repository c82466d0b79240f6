#include "marker/lamp_tracker.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "marker/lamp_center.h"
#include "marker/lamp_detector.h"
#include "marker/lamp_pair.h"
#include "marker/vp_dot.h"

namespace planar {
namespace {

// Half the side of a window over the predicted distance of the lamps: the other lamp stays out.
constexpr double kWindowShare = 0.5;
constexpr double kLeastWindow_px = 16.0, kMostWindow_px = 256.0;
constexpr std::size_t kMostCandidates = 32;

/// The blob under a predicted place; the level is learned from a window round it [Otsu 1979].
std::optional<Blob> blob_at(const cv::Mat& image, const Eigen::Vector2d& uv_px, double half_side_px,
                            cv::Mat& buffer) {
  const cv::Rect window = window_round(uv_px, half_side_px) & cv::Rect({0, 0}, image.size());
  if (window.empty()) return std::nullopt;
  const double level = cv::threshold(image(window), buffer, 0, 255, cv::THRESH_OTSU);
  const std::optional<VpDot> dot = vp_dot(image, window, uv_px, static_cast<int>(level) + 1);
  if (!dot || !is_lamp_like(dot->blob)) return std::nullopt;
  return dot->blob;
}

/// The expectation in pixels of an image whose first pixel is `origin` on the sensor.
PairExpectation shifted(PairExpectation expectation, const Eigen::Vector2d& origin) {
  if (expectation.predicted_px) {
    for (Eigen::Vector2d& uv : *expectation.predicted_px) uv -= origin;
  }
  return expectation;
}

}  // namespace

struct LampTracker::Impl {
  CenterMethod method;
  LampDetector detector;
  cv::Mat threshold_buffer;

  /// The blobs at both predicted places; empty unless each holds a lamp of its own.
  std::vector<Blob> blobs_at_prediction(const cv::Mat& image, const PairExpectation& expectation) {
    if (!expectation.predicted_px) return {};
    const auto& [first, second] = *expectation.predicted_px;
    const double half_side =
        std::clamp(kWindowShare * (second - first).norm(), kLeastWindow_px, kMostWindow_px);
    const std::optional<Blob> a = blob_at(image, first, half_side, threshold_buffer);
    const std::optional<Blob> b = blob_at(image, second, half_side, threshold_buffer);
    if (!a || !b || !(a->box_px & b->box_px).empty()) return {};
    return {*a, *b};
  }

  LampPair measure(const cv::Mat& image, const std::vector<Blob>& blobs,
                   const PairExpectation& expectation) const {
    std::vector<Eigen::Vector2d> places;
    for (const Blob& blob : blobs) places.push_back(blob.uv_px);
    const PairChoice choice = choose_pair(places, expectation);
    LampPair pair;
    pair.status = choice.status;
    if (pair.status != LampStatus::kOk && pair.status != LampStatus::kAmbiguous) return pair;
    for (std::size_t i : {0u, 1u}) {
      pair.lamps[i] = measure_lamp(image, blobs[choice.index[i]], method);
      if (pair.lamps[i].status != LampStatus::kOk) pair.status = pair.lamps[i].status;
    }
    if (!choice.is_unique) pair.lamps[0].status = pair.lamps[1].status = LampStatus::kAmbiguous;
    return pair;
  }
};

LampTracker::LampTracker(CenterMethod method) : impl_(new Impl{method, {}, {}}) {}
LampTracker::~LampTracker() = default;
LampTracker::LampTracker(LampTracker&&) noexcept = default;
LampTracker& LampTracker::operator=(LampTracker&&) noexcept = default;

LampPair LampTracker::locate(const Frame& frame, const PairExpectation& expectation) {
  require_8_bit(frame.image);
  const Eigen::Vector2d origin(frame.region_px.x, frame.region_px.y);
  const PairExpectation local = shifted(expectation, origin);

  const std::vector<Blob> predicted = impl_->blobs_at_prediction(frame.image, local);
  LampPair pair = impl_->measure(frame.image, predicted, local);
  if (pair.status != LampStatus::kOk) {
    std::vector<Blob> candidates = impl_->detector.detect(frame.image);
    if (candidates.size() > kMostCandidates) candidates.resize(kMostCandidates);
    pair = impl_->measure(frame.image, candidates, local);
  }
  for (LampCenter& lamp : pair.lamps) lamp.uv_px += origin;
  return pair;
}

}  // namespace planar
