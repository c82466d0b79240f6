#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_arm.h"
#include "planar_servo/virtual_cell/virtual_board.h"
#include "planar_servo/virtual_cell/virtual_drive.h"
#include "planar_servo/virtual_cell/virtual_lamps.h"
#include "planar_servo/virtual_cell/virtual_works.h"

namespace planar {

/// Turns grey levels into the output of an 8-bit sensor: shot noise of variance level/gain, read
/// noise, rounding, clipping to 0..255.
class SensorNoise {
 public:
  SensorNoise(const NoiseTruth& truth, std::uint64_t seed);

  /// Fills `image` with noisy background. Rows are copied from random places in a bank of dark
  /// pixels, because fresh noise for a whole sensor takes too long.
  void fill_dark(cv::Mat& image, Random& random) const;

  /// Writes `levels` above the background (CV_32FC1) with fresh noise into `image` (CV_8UC1, same
  /// size).
  void expose(const cv::Mat1f& levels, cv::Mat image, Random& random) const;

 private:
  NoiseTruth truth_;
  std::vector<float> normals_;      ///< quantiles of the normal distribution
  std::vector<std::uint8_t> bank_;  ///< dark pixels
};

/// Renders frames of works and lamps, or of the calibration board, which hides them while it is in
/// view.
/// Exposures begin at whole multiples of the frame period; waiting for one advances the clock. An
/// arm that moves is smeared over the exposure, which takes its time; one at rest is seen at once.
class VirtualCamera final : public FrameSource {
 public:
  VirtualCamera(const Truth& truth, const VirtualHardware& hardware, const VirtualLens& lens,
                VirtualArm& arm, const VirtualBoard& board, VirtualClock& clock);

  cv::Size sensor_size_px() const override { return sensor_px_; }
  void set_region(const cv::Rect& region_px) override;
  FrameResult next_frame() override;
  std::optional<std::string> fault() const override { return std::nullopt; }
  FrameCounts counts() const override { return {taken_, 0, 0, 0}; }
  CameraExposure exposure() const override { return exposure_; }
  void set_exposure(const CameraExposure& exposure) override;

  /// Renders what the sensor sees of `region_px` now, `brightness` times as bright as usual. The
  /// same exposure number gives the same noise.
  cv::Mat expose(const cv::Rect& region_px, double brightness, std::uint64_t exposure);

  VirtualWorks& works() { return works_; }

 private:
  static constexpr double kUsualTime_s = 0.010;
  /// At 50 mm/s a lamp moves by a quarter of a pixel from one of these to the next.
  static constexpr int kMomentsOfExposure = 8;

  /// Exposes while the clock advances by the exposure's time.
  cv::Mat expose_moving(double brightness, std::uint64_t exposure);
  /// Returns the parts of the scene, whose light adds up.
  std::vector<Light> lights(double t_s);

  cv::Size sensor_px_;
  double frame_rate_hz_;
  std::uint64_t seed_;
  const VirtualLens& lens_;
  VirtualArm& arm_;
  const VirtualBoard& board_;
  VirtualClock& clock_;
  VirtualLamps lamps_;
  VirtualWorks works_;
  SensorNoise noise_;
  cv::Rect region_px_;
  CameraExposure exposure_{kUsualTime_s, 0.0};
  std::uint64_t taken_{0};
  /// Number of the next one, in frame periods since the clock's start.
  std::uint64_t next_exposure_{0};
};

}  // namespace planar
