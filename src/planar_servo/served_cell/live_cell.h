#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <opencv2/core.hpp>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/virtual_cell/virtual_cell.h"

namespace planar {

/// A virtual cell on real time, for the threads of servers: its clock keeps up with the steady
/// clock.
class LiveCell {
 public:
  /// `age_s`: what the cell's own clock shows at the beginning, for a cell that has run before.
  /// Throws like VirtualCell.
  LiveCell(const Truth& truth, const VirtualHardware& hardware, double age_s = 0.0);

  /// Called before anything of the cell is looked at, to bring motors up to date.
  void set_mover(std::function<void(VirtualCell&)> mover);

  /// What the sensor shows of the region now, `brightness` times as bright as usual. What lies
  /// outside the sensor is black.
  cv::Mat expose(const cv::Rect& region_px, double brightness);

  /// For the scorer only: where the tool really is now.
  TipPose true_tip();

 private:
  void catch_up();

  std::mutex mutex_;
  VirtualCell cell_;
  cv::Size sensor_px_;
  SteadyClock steady_;
  double offset_s_;
  std::uint64_t exposures_{0};
  std::function<void(VirtualCell&)> mover_;
};

}  // namespace planar
