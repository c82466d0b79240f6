#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace planar {

struct TrackerReading {
  double t_s{0.0};
  Eigen::Vector3d p_L{0.0, 0.0, 0.0};  ///< reflector's centre in the tracker's frame, metres
};

/// A laser tracker. It returns nothing when the beam is lost or nobody delivers readings.
class Tracker {
 public:
  virtual ~Tracker() = default;
  virtual std::optional<TrackerReading> measure_tool() = 0;
  virtual std::optional<TrackerReading> measure_monument(const std::string& id) = 0;
};

}  // namespace planar
