#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/text.h"

namespace planar {

/// Shows work under way: a picture with what is marked in it, and lines of text beside it.
struct LiveView {
  enum class Color { kInk, kFaint, kSeen, kWanted, kAlarm, kFixed };
  enum class Shape { kCross, kRing, kBox };

  struct Mark {
    Eigen::Vector2d uv_px;  ///< on the sensor
    Shape shape;
    double radius_px;  ///< in the view
    Color color;
  };
  struct Line {
    std::string text;
    Color color;
  };

  std::string title;
  cv::Mat picture;                    ///< CV_8UC1; shared, not copied
  cv::Point2d corner_px{};            ///< its first pixel on the sensor
  std::vector<cv::Rect2d> open_px{};  ///< frames about parts of the picture
  std::vector<Mark> marks{};          ///< those off the picture are left out
  std::vector<Line> lines{};          ///< an empty one is a gap
};

/// The width and height of the panel in which a view shows its picture.
constexpr int kLivePanel_px = 512;

/// Returns the view as an image of 1000 x 580 pixels, CV_8UC3. The picture fills the panel from
/// (16, 48) as far as its shape allows.
cv::Mat drawn(const LiveView& view);

/// Keeps the newest view in a picture file.
class LivePicture {
 public:
  explicit LivePicture(std::filesystem::path file) : file_(std::move(file)) {}

  /// Replaces the file as a whole, so that it is never half written. Where that fails it warns,
  /// once, and draws no more.
  void show(const LiveView& view);

 private:
  std::filesystem::path file_;
  bool failed_{false};
};

/// Says what `--display` asks for.
enum class DisplayPolicy { kAuto, kNone };

constexpr Named<DisplayPolicy> kDisplayPolicies[] = {{DisplayPolicy::kAuto, "auto"},
                                                     {DisplayPolicy::kNone, "none"}};

/// Returns what shows views in `file`; null where nothing is to be drawn.
inline std::unique_ptr<LivePicture> open_display(DisplayPolicy policy,
                                                 const std::filesystem::path& file) {
  return policy == DisplayPolicy::kNone ? nullptr : std::make_unique<LivePicture>(file);
}

}  // namespace planar
