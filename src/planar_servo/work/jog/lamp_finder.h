#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// Says how bright the lit part of an image is.
struct ExposureReading {
  int peak_level{0};            ///< grey level of the brightest part, without a few hot pixels
  double saturated_share{0.0};  ///< share of the lit pixels that are at 255

  /// Returns true when the lamps use less than half of the grey levels.
  bool too_dark() const;
  /// Returns true when more than 2 % of the lit pixels are saturated.
  bool too_bright() const;
  /// Returns one line with a bar, the figures, and what to do.
  std::string text() const;
};

/// Reads the exposure of an image, which is CV_8UC1 and not empty. Pixels are lit that lie above
/// the middle between the median level and the peak.
ExposureReading read_exposure(const cv::Mat& image);

/// How the grey levels of a picture of one lamp and its surroundings are spread.
struct LampLevels {
  int ambient{0}, lit{0};     ///< medians around the lamp and of it
  double dark_share{0.0};     ///< of the surroundings, at 0
  double clipped_share{0.0};  ///< of the lamp, at 255
  std::string bars;           ///< a bar for each 16 levels, as high as the logarithm of its share

  std::string text() const;
  /// Says what to change; empty where nothing is cut and half of the levels are used.
  std::string remedy() const;
};

/// Returns the levels of an image of one lamp, CV_8UC1. The lamp is what lies above the middle
/// between the median and the brightest level.
LampLevels read_lamp_levels(const cv::Mat& image);

/// Two lamps as a frame shows them, in any order, and how wide their edges are, pixels.
struct SightedLamps {
  std::array<LampCenter, 2> lamps;
  std::array<double, 2> edges_px;

  double mean_edge_px() const { return 0.5 * (edges_px[0] + edges_px[1]); }
};

/// Looks for two lamps in a frame, however far out of focus they are. `fixed_px` are lights that
/// are known to be others. With `near_px` they are sought there first. Empty unless two lights are
/// there.
std::optional<SightedLamps> sight_lamps(const Frame& frame,
                                        const std::vector<Eigen::Vector2d>& fixed_px,
                                        const std::optional<LampPixels>& near_px = {});

/// Finds the lamps wherever the arm is, calibrated or not, and says how sharp they are.
class LampFinder {
 public:
  /// `camera` must outlive this. `follow_region_px` is the side of the region that follows the
  /// lamps while the lens is turned.
  LampFinder(LampScene scene, CenterMethod method, FrameSource& camera, int follow_region_px);

  /// Takes a frame of the whole sensor. Throws WorkError when the camera delivers none.
  Frame whole_frame() { return next_frame({{}, camera_.sensor_size_px()}); }

  /// Searches a whole frame and returns in words where the lamps are: in the picture and, once the
  /// workplane is calibrated, on it, uncompensated. Throws WorkError without a frame or a pair.
  std::string find();

  /// Says in one line how wide the edges of two lamps are, on the mean and each, the least mean so
  /// far, and how bright the picture is: the figures to turn a lens by. After the first whole frame
  /// only a region is read. Throws WorkError without a frame or two lamps.
  std::string focus();
  /// Lets focus() begin anew with the least width.
  void forget_best() { best_px_.reset(); }

 private:
  Frame next_frame(const cv::Rect& region_px);
  std::optional<SightedLamps> sight(const cv::Rect& region_px);

  LampScene scene_;
  CenterMethod method_;
  FrameSource& camera_;
  int follow_region_px_;
  std::optional<Eigen::Vector2d> middle_px_;  ///< between the lamps, where they were seen last
  std::optional<double> best_px_;
  std::optional<ExposureReading> exposure_;  ///< of the last frame
};

}  // namespace planar
