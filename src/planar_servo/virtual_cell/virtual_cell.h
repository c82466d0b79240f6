#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_arm.h"
#include "planar_servo/virtual_cell/virtual_drive.h"
#include "planar_servo/virtual_cell/virtual_lamps.h"
#include "planar_servo/virtual_cell/virtual_lens.h"
#include "planar_servo/virtual_cell/virtual_sheets.h"

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

/// Simulates a tracker with its own frame, white noise, a small smooth bias, errors of its angles
/// and a drifting station. Readings of the tool, but not of monuments, may be outliers or mixed up
/// with those of an earlier place.
class VirtualTracker final : public Tracker {
 public:
  VirtualTracker(const Truth& truth, const VirtualHardware& stated, VirtualArm& arm,
                 const Clock& clock);

  TrackerAnswer measure_tool(const std::string& place) override;
  /// Throws std::invalid_argument for an id that is not a monument.
  TrackerAnswer measure_monument(const std::string& id) override;

 private:
  TrackerAnswer measure(const Eigen::Vector3d& p_B, const std::optional<OutlierTruth>& outliers);
  /// Returns the place whose readings count as those of the newest place.
  std::size_t paired_place() const;

  TrackerTruth truth_;
  Eigen::Vector3d reflector_T_;
  std::optional<OutlierTruth> outliers_;
  std::uint64_t seed_;
  VirtualMonuments monuments_B_;
  VirtualArm& arm_;
  const Clock& clock_;
  std::uint64_t readings_{0};
  std::string place_;
  std::vector<Eigen::Vector3d> places_B_;  ///< of the reflector, one for each place measured
};

/// Simulates a cell: arm, camera, lamps and tracker behind the interfaces of real devices, on a
/// clock of their own. Only its own devices and the scorer see the truth. The same truth and the
/// same calls give the same bytes.
class VirtualCell {
 public:
  /// Takes arm, drives and monuments from the truth, the rest from the stated hardware. Throws
  /// std::invalid_argument for impossible hardware: an empty sensor, a frame rate or limit that is
  /// not finite and positive, a scale that is zero or not finite, a sense other than +-1.
  VirtualCell(const Truth& truth, const VirtualHardware& hardware);

  Clock& clock() { return clock_; }
  FrameSource& camera() { return camera_; }
  /// Returns the drive of joint 0, 1 or 2; throws std::out_of_range for others.
  PulseDrive& drive(int joint) { return arm_.drive(joint); }
  DriveGroup& drives() { return drives_; }
  Tracker& tracker() { return tracker_; }
  BoardPresenter& board_presenter() { return board_; }

  // Servers, which show this cell to others as real devices, use these three.
  /// Renders what the camera's sensor sees now; see VirtualCamera::expose().
  cv::Mat expose(const cv::Rect& region_px, double brightness, std::uint64_t exposure) {
    return camera_.expose(region_px, brightness, exposure);
  }
  /// Lays the last work of the truth elsewhere on its height: its origin at a place in the base
  /// frame. Returns false where there is no work.
  bool lay_work(const Eigen::Vector2d& p_B, double turn_rad);
  /// Turns a motor to a position from outside, without its drive. Pulses count as its drive's did
  /// at first. Steps must be so small that the motor does not turn back on the way.
  void turn_motor(int joint, std::int32_t pulses) { arm_.drive(joint).turn_shaft(pulses); }

  /// Returns, for the scorer of `_truth` figures only, the true end point P in the base frame and
  /// the direction from lamp 1 to lamp 2.
  TipPose true_tip() const { return arm_.tip(); }

  /// Returns the true place of the elbow in the base frame, for what the arm may touch.
  Eigen::Vector2d true_elbow() const { return arm_.elbow(); }

 private:
  VirtualClock clock_;
  VirtualLens lens_;
  mutable VirtualArm arm_;  ///< catches up with the clock when it is looked at
  VirtualBoard board_;
  VirtualCamera camera_;
  VirtualTracker tracker_;
  SeparateDrives drives_;
};

}  // namespace planar
