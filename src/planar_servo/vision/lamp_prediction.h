#pragma once

#include <array>
#include <opencv2/core/types.hpp>
#include <optional>

#include "planar_servo/calibration/coarse_view.h"
#include "planar_servo/calibration/tool_offsets.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lens/workplane.h"

namespace planar {

/// Share by which the pair's distance in pixels may differ from a prediction through a calibrated
/// plane, which is good to a per cent or two; a wrong light differs by far more.
constexpr double kCalibratedShare = 0.03;

/// The lamps on the tool, as the cell file has them.
struct LampLayout {
  double separation_m{0.0};
  std::array<double, 2> diameters_m{0.0, 0.0};

  std::array<double, 2> diameter_over_separation() const {
    return {diameters_m[0] / separation_m, diameters_m[1] / separation_m};
  }
};

LampLayout lamp_layout(const CellSettings& cell);

/// Lamps 1 and 2 expected at these pixels, their distance right to `share`.
PairExpectation expect_lamps(const LampLayout& layout,
                             const std::array<Eigen::Vector2d, 2>& predicted_px, double share);

/// What is known of the place where images were taken.
struct LampScene {
  cv::Size sensor_px;
  LampLayout lamps;
  std::optional<Workplane> workplane;
  ToolOffsets tool;  ///< zero, an ideal tool, until it is known
};

/// From the cell file and those of its files that exist already.
LampScene lamp_scene(const CellSettings& cell);

/// Says what is known of the lamps in an image: their size, and where they should be, from the
/// commanded pose through the workplane or else through a coarse view.
class LampPrediction {
 public:
  /// The scene must outlive the prediction.
  LampPrediction(const LampScene& scene, std::optional<CoarseView> view);

  PairExpectation of(const std::optional<TipPose>& commanded) const;

 private:
  std::optional<std::array<Eigen::Vector2d, 2>> lamps_px(const TipPose& tip) const;

  const LampScene& scene_;
  std::optional<CoarseView> view_;
};

}  // namespace planar
