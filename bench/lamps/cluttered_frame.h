#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "support/rendered_lamp.h"

namespace planar::bench {

/// Says what full frames of one kind show beside two lamps.
struct FrameKind {
  std::string name;
  int specks{0};             ///< number of bright discs of 1 to 6 px
  bool other_lights{false};  ///< streaks, dim reflections and a third lamp
  bool any_lamp{false};      ///< lamps of 12 to 120 px and 40 to 400 levels, else of 40 px and 180
};

/// A full frame of 5120 x 5120 pixels that is drawn anew again and again.
class ClutteredFrame {
 public:
  explicit ClutteredFrame(unsigned seed);

  /// Draws two equal lamps somewhere in the frame, and the clutter. The third lamp stands at
  /// another distance from both.
  void draw(const FrameKind& kind);

  const cv::Mat& image() const { return image_; }
  const std::array<test::RenderedLamp, 2>& lamps() const { return lamps_; }
  const std::optional<test::RenderedLamp>& third_lamp() const { return third_lamp_; }
  /// Returns the distance between the two lamps.
  double separation_px() const;

 private:
  void restore();
  void add(const cv::Mat& light, const cv::Point& corner);
  void add_lamp(const test::RenderedLamp& lamp);
  void add_specks(int count);
  void add_streak();
  void add_reflection();
  Eigen::Vector2d draw_place(double margin_px);
  double uniform(double from, double to);

  std::mt19937 random_;
  cv::Mat dark_, image_;
  std::vector<cv::Mat> speck_light_;
  std::vector<cv::Rect> touched_;
  std::array<test::RenderedLamp, 2> lamps_;
  std::optional<test::RenderedLamp> third_lamp_;
};

}  // namespace planar::bench
