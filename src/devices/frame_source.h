#pragma once

#include "core/frame.h"

namespace planar {

enum class FrameStatus { kOk, kTimeout, kIncomplete, kLost };

struct FrameResult {
  FrameStatus status{FrameStatus::kTimeout};
  Frame frame;  ///< valid only when status is kOk
};

/// A camera: "the next frame, its time, or why not".
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual cv::Size sensor_size_px() const = 0;

  /// Restricts the following frames to a region of the sensor. Throws std::invalid_argument when
  /// the region is empty or leaves the sensor.
  virtual void set_region(const cv::Rect& region_px) = 0;

  /// Waits for a frame whose exposure begins after this call.
  virtual FrameResult next_frame() = 0;
};

}  // namespace planar
