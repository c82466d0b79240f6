#pragma once

#include <optional>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/console/watch/pictures.h"
#include "planar_servo/lamps/lamp_detector.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Keeps the pictures of a cell's camera and notes what they show: lamps, sharpness and fixed
/// lamps. The thread that has the camera calls all but pictures().
class PictureWatch {
 public:
  PictureWatch(const CellSettings& cell, const std::optional<VisionCalibration>& vision,
               StateBoard& board);

  /// Takes any frame that the camera has given. Where somebody looks, finds what it shows a few
  /// times a second.
  void take(const Frame& frame, bool is_watched);
  /// Begins anew with the sharpest edges.
  void forget_best() { best_px_.reset(); }

  Pictures& pictures() { return pictures_; }

 private:
  void examine(const Frame& frame);
  std::vector<FixedLampState> fixed_lamps(const Frame& frame);

  StateBoard& board_;
  Pictures pictures_;
  SteadyClock clock_;
  CenterMethod method_;
  std::vector<ReferenceLamp> fixed_;
  LampDetector detector_;
  std::optional<LampPixels> lamps_px_;  ///< where they were last
  std::optional<double> best_px_;
  double examined_s_{0.0};  ///< when, by the steady clock
};

}  // namespace planar
