#pragma once

#include <array>
#include <opencv2/core/types.hpp>
#include <optional>

#include "app/lamp_images.h"
#include "calibration/coarse_view.h"
#include "calibration/tool_offsets.h"
#include "camera/workplane.h"
#include "files/cell_file.h"
#include "marker/lamp.h"

namespace planar {

/// Share by which the pair's distance in pixels may differ from a prediction through a calibrated
/// plane, which is good to a per cent or two; a wrong light differs by far more.
constexpr double kCalibratedShare = 0.03;

/// Lamps 1 and 2 expected at these pixels, their distance right to `share`.
PairExpectation expect_lamps(const std::array<Eigen::Vector2d, 2>& predicted_px, double share);

/// What is known of the place where images were taken.
struct LampScene {
  cv::Size sensor_px;
  double separation_m{0.0};
  std::optional<Workplane> workplane;
  ToolOffsets tool;  ///< zero, an ideal tool, until it is known
};

/// From the cell file and those of its files that exist already.
LampScene lamp_scene(const CellSettings& cell);

/// Says where an image's lamps should be, as well as it is known: from the commanded pose through
/// the workplane or else through a coarse view; nothing without either.
class LampPrediction {
 public:
  /// The scene must outlive the prediction.
  LampPrediction(const LampScene& scene, std::optional<CoarseView> view);

  PairExpectation of(const LampImage& image) const;

 private:
  std::optional<std::array<Eigen::Vector2d, 2>> lamps_px(const TipPose& tip) const;

  const LampScene& scene_;
  std::optional<CoarseView> view_;
};

}  // namespace planar
