#pragma once

#include <filesystem>
#include <memory>

#include "planar_servo/devices/frame_source.h"

namespace planar {

/// A camera whose frames are the pictures of a folder, in the order of their names and read by
/// ViSP, or the frames of a video, read by OpenCV with FFmpeg. Colours become grey. After the last
/// frame the camera is lost.
class FileSource final : public FrameSource {
 public:
  /// `frame_rate_hz` dates the pictures of a folder from 0 s on; a video has its own rate. Throws
  /// InputError when there is no picture.
  FileSource(const std::filesystem::path& folder_or_video, double frame_rate_hz);
  ~FileSource() override;

  cv::Size sensor_size_px() const override;
  void set_region(const cv::Rect& region_px) override;
  /// Returns kIncomplete for a picture that cannot be read or differs in size from the first.
  FrameResult next_frame() override;
  std::optional<std::string> fault() const override;
  FrameCounts counts() const override;
  CameraExposure exposure() const override { return {}; }
  /// Throws WorkError: pictures of files cannot be exposed again.
  void set_exposure(const CameraExposure& exposure) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
