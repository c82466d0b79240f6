#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "planar_servo/lamps/blob.h"

namespace planar {

/// Finds bright patches that may be lamps of 12 px diameter or more. It reads sparse rows only, one
/// of which every lamp must cross, and learns thresholds from the levels nearby. A patch that is no
/// lamp is split by higher thresholds and by the discs that fit into it, because a lamp may touch
/// other lights. It keeps its memory from image to image.
class LampDetector {
 public:
  /// Returns the candidates, those cut by the image's edge included, by falling evidence (diameter
  /// times contrast); none for an image too small for a lamp. The list is valid until the next
  /// call. Throws std::invalid_argument unless the image is CV_8UC1.
  const std::vector<Blob>& detect(const cv::Mat& image);

  /// Returns the candidates that reach into the window.
  const std::vector<Blob>& detect(const cv::Mat& image, const cv::Rect& window_px);

 private:
  void learn_thresholds(const cv::Mat& image, const cv::Rect& band, int tile_width);
  void search_band(const cv::Mat& image, const cv::Rect& band);
  bool search_block(const cv::Mat& image, const Span& block, int threshold, int layer);
  bool examine(const cv::Mat& image, const Span& run, int threshold, int layer);
  bool take_apart(const cv::Mat& image, const Patch& patch, int threshold, int layer);
  bool find_discs(const cv::Mat& image, const Patch& patch, int threshold);
  bool add_disc(const cv::Mat& image, const Patch& patch, const cv::Point& center, double reach_px,
                int threshold);

  PatchGrower patches_;
  std::vector<Blob> found_;
  std::vector<Span> disc_;
  std::vector<LevelHistogram> tiles_;
  std::vector<int> thresholds_;
  cv::Mat mask_, depth_;
};

}  // namespace planar
