#pragma once

#include <optional>

#include "planar_servo/calibration/tool_offsets.h"
#include "planar_servo/devices/frame_source.h"
#include "planar_servo/error_map/error_map.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/lens/workplane.h"
#include "planar_servo/servo/tip_sensor.h"
#include "planar_servo/vision/lamp_prediction.h"

namespace planar {

/// What a calibrated cell knows of its vision.
struct VisionCalibration {
  Workplane workplane;
  ToolOffsets tool;
  std::optional<ErrorMap> error_map;  ///< none: the position is not compensated
};

/// Reads the cell's camera, workplane, tool and, when asked for, error map. Throws InputError
/// naming the program that makes a missing file.
VisionCalibration read_vision(const CellSettings& cell, bool with_error_map);

/// The end point by its lamps: frame -> lamps (px) -> workplane (m) -> error map. The region of the
/// sensor follows the commanded pose; lamps that are not in it are looked for in one full frame.
class LampTipSensor final : public TipSensor {
 public:
  /// The camera must outlive the sensor.
  LampTipSensor(const CellSettings& cell, VisionCalibration vision, CenterMethod method,
                FrameSource& camera);

  /// Lets the camera's region go where the lamps should be, so that it need not send whole frames
  /// until the first measurement.
  void aim(const TipPose& expected);

  TipMeasurement measure(const TipPose& expected, int frames) override;
  std::optional<std::string> fault() const override { return camera_.fault(); }

  /// The frame looked at last; without an image before the first one.
  const Frame& last_frame() const { return last_frame_; }

  /// Lamps 1 and 2 with the end point at `tip`; empty where the camera does not see them.
  std::optional<std::array<Eigen::Vector2d, 2>> lamps_at(const TipPose& tip) const;

 private:
  struct Sight {
    LampPair pair;
    double t_s{0.0};
    FrameStatus frame{FrameStatus::kOk};
  };

  void aim_at(const std::array<Eigen::Vector2d, 2>& lamps_px);
  /// The pair of lamps in a frame, which is kept, if it has one.
  Sight look_at(const FrameResult& result, const PairExpectation& expectation);
  Sight look(const FrameResult& result, const PairExpectation& expectation);
  TipMeasurement position(TipMeasurement measurement,
                          const std::array<Eigen::Matrix2d, 2>& covariances_px2) const;

  CameraSettings camera_settings_;
  LampLayout lamps_;
  VisionCalibration vision_;
  LampTracker tracker_;
  FrameSource& camera_;
  Frame last_frame_;
};

}  // namespace planar
