#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/loop/servo/servo_result.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// Returns the region of the sensor that follows the lamps: a square with sides of `side_px`, cut
/// to the sensor's size and centred on `center_px` where that keeps it on the sensor.
cv::Rect follow_region(const cv::Size& sensor_px, int side_px, const Eigen::Vector2d& center_px);

/// Measures the end point by its lamps with a camera, whose region follows the commanded pose. When
/// they are not in it, one full frame is searched. Where lamps are fixed to the base, a full frame
/// every so often shows how the image has moved; that motion is taken out.
class LampTipSensor final : public TipSensor {
 public:
  /// Takes a camera that outlives the sensor, and the side of the region that follows the lamps.
  LampTipSensor(VisionCalibration vision, CenterMethod method, FrameSource& camera,
                int follow_region_px);
  /// Moves the camera's region to `expected`, so that the first look needs no whole frame.
  void aim(const TipPose& expected);

  TipMeasurement measure(const TipPose& expected, int frames) override;
  std::optional<std::string> fault() const override { return camera_.fault(); }
  /// Searches the whole frame for two lamps, wherever the tool should be. Returns their places on
  /// the plane, uncompensated and in any order; empty unless two lamps are found.
  std::optional<std::array<Eigen::Vector2d, 2>> look_around();
  /// Returns the lamps' last appearance, found or not; 0 for what was not seen.
  const LampLooks& last_looks() const { return last_looks_; }
  /// Returns the frame that was looked at last. It has no image before the first look.
  const Frame& last_frame() const { return last_frame_; }
  /// Returns where lamps 1 and 2 are with the end point at `tip`; empty where they are not seen.
  std::optional<LampPixels> lamps_at(const TipPose& tip) const;

 private:
  /// The outcome of one frame: the frame's status and, where that is kOk, the pair in it.
  struct Look {
    LampPair pair;
    double t_s{0.0};
    FrameStatus frame{FrameStatus::kOk};

    bool found() const { return frame == FrameStatus::kOk && pair.status == LampStatus::kOk; }
  };

  TipMeasurement look_at_tool(const TipPose& expected, int frames);
  void aim_at(const LampPixels& lamps_px);
  /// Keeps the frame and locates the lamps in it.
  Look locate(const FrameResult& result, const PairExpectation& expectation);
  /// Locates the lamps in the frame or, when they are not in its region, in a full one.
  Look look(const FrameResult& result, const PairExpectation& expectation);
  /// Looks at the reference lamps in a whole frame if that is due. Returns a failed look when the
  /// frame is missing or the lamps show that the calibration is void.
  std::optional<TipMeasurement> watch_camera(double t_s);
  /// Positions the tool by its lamps as they are seen now.
  TipMeasurement position(const Observation& seen) const;

  VisionCalibration vision_;
  LampTracker tracker_;
  ReferenceWatch watch_;
  FrameSource& camera_;
  int follow_region_px_;
  Frame last_frame_;
  LampLooks last_looks_{};
};

}  // namespace planar
