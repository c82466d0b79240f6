#pragma once

#include <memory>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/hardware/cameras/aravis_settings.h"

namespace planar {

/// A GigE Vision or USB3 Vision camera through Aravis. One thread makes every call to the camera
/// and keeps frames coming, by software triggers if need be, so that a dead camera shows at once. A
/// lost camera is opened again, with growing pauses, and its settings are applied anew. Incomplete
/// and repeated frames are counted and never handed over.
class AravisCamera final : public FrameSource {
 public:
  /// Opens the camera. Throws WorkError when it does not answer or refuses a setting, and
  /// InputError for settings that no camera can have.
  explicit AravisCamera(const AravisSettings& settings);
  ~AravisCamera() override;

  cv::Size sensor_size_px() const override;
  /// Moves the region while frames stream. Another size restarts the stream and waits for its first
  /// frame. The frames' region may be larger than asked for, by the raster of the camera.
  void set_region(const cv::Rect& region_px) override;
  /// Returns a frame exposed after this call. A free-running or hardware-triggered exposure is
  /// dated by the camera's clock (CameraClock): due arrival less exposure time.
  FrameResult next_frame() override;
  FrameResult following_frame() override;
  std::optional<std::string> fault() const override;
  FrameCounts counts() const override;
  std::vector<std::pair<std::string, std::string>> features() const override;
  CameraExposure exposure() const override { return exposure_; }
  /// Waits until the camera has taken it. Throws InputError also for more than the frame period.
  void set_exposure(const CameraExposure& exposure) override;

 private:
  struct Impl;
  CameraExposure exposure_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
