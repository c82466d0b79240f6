#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "planar_servo/devices/frame_source.h"
#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/lamp_detector.h"
#include "planar_servo/lamps/vp_dot_tracker.h"

namespace planar {

/// Says which candidates are the two lamps.
struct PairChoice {
  /// kOk, kAmbiguous, kNoLamp, kOneLamp or kWrongDistance.
  LampStatus status{LampStatus::kNoLamp};
  /// Lamps 1 and 2 (kOk), or the two lamps in either order (kAmbiguous).
  std::array<std::size_t, 2> index{0, 0};
  /// False when several pairs are possible and no prediction decides between them. `index` is then
  /// the first of these pairs.
  bool is_unique{true};
};

/// Chooses the two lamps among candidates that are given by falling evidence. Of the pairs with the
/// right distance and sizes it takes the one nearest to the prediction. Which lamp is which follows
/// from the predicted direction, unless the pair lies across it, and from sizes and contrasts where
/// the lamps differ. The pair stays kAmbiguous when these contradict each other or say nothing.
PairChoice choose_pair(const std::vector<Blob>& candidates, const PairExpectation& expectation);

/// Finds the two lamps in a frame (whole sensor or region): where a prediction is given, in a
/// window round each predicted place; without one, or when that fails, in the whole image. Then
/// measures each centre by the method asked for, checks the distance and decides which lamp is
/// which.
///
/// With kVpDot2 the lamps found are then followed from frame to frame by a vpDot2 each (see
/// VpDotTracker for what is kept); the search begins anew when one of them is lost or the two no
/// longer make the pair expected. With every other method nothing is kept that changes a result:
/// the same frame and expectation always give the same pair.
class LampTracker {
 public:
  explicit LampTracker(CenterMethod method) : method_(method) {}

  LampPair locate(const Frame& frame, const PairExpectation& expectation);

  /// Follows no lamp any more, so that the next frame is looked at as if it were the first one.
  void forget();

 private:
  void search_windows(const cv::Mat& image, const PairExpectation& expectation);
  void search_image(const cv::Mat& image, const PairExpectation& expectation);
  /// Drops the candidates that are fixed lights.
  void drop_fixed(const std::vector<Eigen::Vector2d>& fixed_px);
  /// measure(lamp, candidate) gives the centre of lamp 0 or 1.
  template <typename Measure>
  LampPair choose(const PairExpectation& expectation, const Measure& measure) const;
  LampPair follow(const Frame& frame, const PairExpectation& expectation);
  LampPair search(const Frame& frame, const PairExpectation& expectation);
  LampPair measure(const Frame& frame, const PairExpectation& expectation);

  CenterMethod method_;
  LampDetector detector_;
  std::vector<Blob> candidates_;
  std::array<VpDotTracker, 2> dots_;
};

}  // namespace planar
