#pragma once

#include <array>
#include <mutex>
#include <string>
#include <vector>

#include "device_host/wire_tap.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/machine/rehearsal/live_cell.h"
#include "support/emulated_tic.h"

namespace planar::test {

/// The tool as it was at an exposure, on the steady clock.
struct TrueTip {
  double t_s{0.0};
  TipPose tip;
};

/// The arm of a virtual cell, turned by three emulated Tics and seen by a served camera.
class HostedArm {
 public:
  /// `age_s` as LiveCell has it. The Tics stand at the cell's home and know it; each has a reverse
  /// switch 1 deg beyond the end of its motor's range.
  HostedArm(const CellSettings& cell, double age_s);

  /// Of the drives of joints 1, 2, 3.
  static const std::array<std::string, 3>& serials();
  WireTap& drive(std::size_t joint) { return taps_.at(joint); }

  /// Takes a picture and notes where the tool is.
  cv::Mat expose(const cv::Rect& region_px, double brightness);

  void power_cycle(std::size_t joint) { tics_.at(joint).power_cycle(); }

  bool moving();
  /// When a motor turned last, on the steady clock.
  double last_motion_s();
  std::vector<TrueTip> true_tips();

 private:
  void teach_home();
  void fit_switches(const TransmissionSettings& transmission,
                    const Eigen::Vector3d& pulses_per_rad);

  SteadyClock clock_;
  std::array<std::int32_t, 3> home_pulses_;
  std::array<EmulatedTic, 3> tics_{EmulatedTic(clock_), EmulatedTic(clock_), EmulatedTic(clock_)};
  std::array<WireTap, 3> taps_{WireTap(tics_[0]), WireTap(tics_[1]), WireTap(tics_[2])};
  LiveCell live_;
  std::mutex mutex_;
  std::vector<TrueTip> true_tips_;
};

}  // namespace planar::test
