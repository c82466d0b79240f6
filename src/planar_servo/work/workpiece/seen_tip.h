#pragma once

#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/workpiece/fiducials.h"

namespace planar {

/// A tip that shows a disc, in pictures at several directions of the tool.
struct SeenTip {
  /// For teach_tip(): each pose with the disc's place taken off, as if the tip had been brought to
  /// a mark at the origin. What is left as the mark's place is an error common to all pictures, as
  /// of the stated height.
  std::vector<TipAtMark> poses;
  double sigma{0.0};         ///< of a pose per axis, without what is common to all; metres
  double sigma_common{0.0};  ///< of what the height's doubt shifts in common, metres
};

/// Finds the disc `form` (its z is the tip's height over the lamps' plane) that keeps its place on
/// the tool in whole frames, one at each pose (base frame, P and direction as vision found them).
/// Throws WorkError when nothing does but the lamps, or several things do, and InputError for
/// another number of frames than poses.
SeenTip see_tip(const std::vector<Frame>& frames, const std::vector<TipAtMark>& poses,
                const VisionCalibration& vision, const Fiducial& form);

/// Throws WorkError when the disc's places differ from the tool's in common by more than their
/// uncertainty: another height than was stated.
void require_height(const TaughtTip& taught, const SeenTip& seen, const VisionCalibration& vision,
                    const std::vector<TipAtMark>& poses);

/// Adds to the tip's covariance what the disc's height leaves in doubt: of a disc that is higher
/// than stated the offset is seen larger, by the height's part of the camera's.
void add_height_doubt(TaughtTip& taught, const VisionCalibration& vision, const Fiducial& form);

}  // namespace planar
