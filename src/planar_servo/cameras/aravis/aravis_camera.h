#pragma once

#include <memory>

#include "planar_servo/cameras/aravis/aravis_settings.h"
#include "planar_servo/devices/frame_source.h"

namespace planar {

/// A GigE Vision or USB3 Vision camera through Aravis. A thread of its own makes every call to the
/// camera and keeps frames coming (by software triggers as well) whether they are asked for or not,
/// so that a dead camera shows at once. A camera that is lost is opened again, with growing pauses,
/// until it is back; its features are applied anew each time. Incomplete and repeated frames are
/// counted and never handed over.
class AravisCamera final : public FrameSource {
 public:
  /// Opens the camera. Throws WorkError when it does not answer or refuses a setting, InputError
  /// for settings that no camera can have.
  explicit AravisCamera(const AravisSettings& settings);
  ~AravisCamera() override;

  cv::Size sensor_size_px() const override;
  /// The frames' own region may be larger: cameras place regions on a raster. Moving a region costs
  /// nothing; another size restarts the stream, and this waits for its first frame.
  void set_region(const cv::Rect& region_px) override;
  /// Without a software trigger an exposure counts from when the frame's arrival was due by the
  /// camera's clock, less the exposure time.
  FrameResult next_frame() override;
  FrameResult following_frame() override;
  std::optional<std::string> fault() const override;
  FrameCounts counts() const override;
  CameraExposure exposure() const override { return exposure_; }
  /// Waits until the camera has it; throws InputError as well when the time does not fit into the
  /// period of the frame rate.
  void set_exposure(const CameraExposure& exposure) override;

 private:
  struct Impl;
  CameraExposure exposure_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
