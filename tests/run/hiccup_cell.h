#pragma once

#include <functional>
#include <optional>
#include <string>

#include "planar_servo/base/devices/frame_source.h"
#include "support/silent_cell.h"

namespace planar::test {

/// Another camera that is at fault as long as somebody says so. Its frames come all the same.
class HiccupCamera final : public FrameSource {
 public:
  explicit HiccupCamera(FrameSource& camera) : camera_(camera) {}

  std::function<bool()> fails{};
  std::function<void()> at_frame{};

  cv::Size sensor_size_px() const override { return camera_.sensor_size_px(); }
  void set_region(const cv::Rect& region_px) override { camera_.set_region(region_px); }
  FrameResult next_frame() override {
    if (at_frame) at_frame();
    return camera_.next_frame();
  }
  std::optional<std::string> fault() const override {
    if (fails && fails()) return "the camera has a hiccup";
    return std::nullopt;
  }
  FrameCounts counts() const override { return camera_.counts(); }
  CameraExposure exposure() const override { return camera_.exposure(); }
  void set_exposure(const CameraExposure& exposure) override { camera_.set_exposure(exposure); }

 private:
  FrameSource& camera_;
};

/// A virtual cell that passes for a real one, with such a camera.
class HiccupCell final : public SilentCell {
 public:
  explicit HiccupCell(const CellSettings& cell) : SilentCell(cell) {}

  HiccupCamera hiccup{virtual_devices().camera()};

  FrameSource& camera() override { return hiccup; }
  /// Returns where the end point is in truth, for a test that waits for something on its way.
  Eigen::Vector2d tip() { return *virtual_devices().truth()->judge("", {}).p; }
};

}  // namespace planar::test
