#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_lamps.h"
#include "planar_servo/virtual_cell/virtual_lens.h"

namespace planar {

/// The workpieces of a virtual cell: plates with marks, of which discs have rims that are a little
/// uneven.
class VirtualWorks {
 public:
  VirtualWorks(const Truth& truth, const VirtualLens& lens, cv::Size sensor_px);

  bool empty() const { return works_.empty(); }

  /// Moves the last one, which does not slide any more: its origin to a place in the base frame.
  void lay_last(const Eigen::Vector2d& p_B, double turn_rad);

  /// Renders each work before noise, within the sensor, dark within these outlines of what is above
  /// it. One at rest is rendered again once the lens or the air has moved.
  std::vector<Light> render(double t_s,
                            const std::vector<std::vector<Eigen::Vector2d>>& above_px = {}) const;

 private:
  struct Rendering {
    double t_s;
    std::vector<Light> lights;
  };

  std::vector<Light> rendered(double t_s) const;
  bool slid_between(double from_s, double to_s) const;

  std::vector<WorkpieceTruth> works_;
  const VirtualLens& lens_;
  cv::Size sensor_px_;
  double blur_px_;
  mutable std::optional<Rendering> rendering_;
};

}  // namespace planar
