#pragma once

#include <filesystem>
#include <memory>

#include "planar_servo/devices/frame_source.h"

namespace planar {

/// The pictures of a folder in the order of their names, by ViSP's readers, or the frames of a
/// video, by OpenCV's with FFmpeg, as if a camera sent them. Colours become grey. After the last
/// one the camera is lost.
class FileSource final : public FrameSource {
 public:
  /// `frame_rate_hz` dates the pictures of a folder, from 0 on; a video knows its own rate. Throws
  /// InputError when there is no picture.
  FileSource(const std::filesystem::path& folder_or_video, double frame_rate_hz);
  ~FileSource() override;

  cv::Size sensor_size_px() const override;
  void set_region(const cv::Rect& region_px) override;
  /// A picture that cannot be read, or of another size than the first, is kIncomplete.
  FrameResult next_frame() override;
  std::optional<std::string> fault() const override;
  FrameCounts counts() const override;
  CameraExposure exposure() const override { return {}; }
  /// Pictures were exposed long ago: throws WorkError.
  void set_exposure(const CameraExposure& exposure) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
