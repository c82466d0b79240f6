#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/lamps/blob.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/lamp_center.h"
#include "planar_servo/lamps/lamp_detector.h"

namespace planar {

/// Which candidates are the two lamps.
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
/// from the predicted direction, unless the pair lies across it, and from sizes where the lamps
/// differ. The pair stays kAmbiguous when these contradict each other or are
/// inconclusive.
PairChoice choose_pair(const std::vector<Blob>& candidates, const PairExpectation& expectation);

/// Finds the two lamps in a frame (whole sensor or region): with a prediction in a window around
/// each predicted place, otherwise or when that fails in the whole image. Then measures each centre
/// by the chosen method, checks the distance and decides which lamp is which.
///
/// With kVpDot2 each lamp found is then followed from frame to frame by a vpDot2 (see VpDotTracker
/// for its state); the search restarts when one of them is lost or the two are no longer the
/// expected pair. The other methods keep nothing that changes a result: the same frame and
/// expectation always give the same pair.
class LampTracker {
 public:
  explicit LampTracker(CenterMethod method) : method_(method) {}

  LampPair locate(const Frame& frame, const PairExpectation& expectation);

  /// Stops following lamps: the next frame is treated like the first one.
  void forget();

 private:
  void search_windows(const cv::Mat& image, const PairExpectation& expectation);
  void search_image(const cv::Mat& image, const PairExpectation& expectation);
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

/// Follows one bright disc through a sequence of images: the nearest patch of about the same size
/// above half its last contrast. With kVpDot2 a vpDot2 follows it (see VpDotTracker), and such a
/// patch is sought when that has lost it.
class DiscTracker {
 public:
  /// `start_px` selects the disc, in the first image that shows one there; without it the most
  /// evident disc is followed.
  explicit DiscTracker(CenterMethod method, std::optional<Eigen::Vector2d> start_px = std::nullopt);

  /// Returns the disc in the next CV_8UC1 image; kNoLamp when it is lost. In the next image it is
  /// sought again near its last place.
  LampCenter locate(const cv::Mat& image);

 private:
  std::optional<Blob> find_again(const cv::Mat& image);
  std::optional<Blob> find_first(const cv::Mat& image);

  CenterMethod method_;
  std::optional<Eigen::Vector2d> start_px_;
  std::optional<Blob> last_;
  LampDetector detector_;
  PatchGrower patches_;
  VpDotTracker dot_;
  std::vector<Blob> found_;
};

}  // namespace planar
