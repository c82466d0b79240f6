#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "planar_servo/calibration/pairing.h"

namespace planar {

/// A stretch of time, on one clock.
struct TimeSpan {
  double begin_s{0.0}, end_s{0.0};
  double middle_s() const { return 0.5 * (begin_s + end_s); }
  double length_s() const { return end_s - begin_s; }
};

/// The reflector rests.
struct Rest {
  TimeSpan span;  ///< on the tracker's clock
  Eigen::Vector3d p_B{0.0, 0.0, 0.0};
};

/// The camera looks at the tool at rest.
struct Look {
  TimeSpan span;  ///< on the camera's clock
  std::array<Eigen::Vector2d, 2> lamps_px;
};

/// Returns the readings in the order of time, those of a tracker that reads all the time only while
/// the reflector rested.
std::vector<ToolReading> readings_at_rest(std::vector<ToolReading> readings);

/// Returns where the reflector rested, in the order of time. `sorted` are the readings of
/// readings_at_rest().
std::vector<Rest> rests_of(const std::vector<ToolReading>& sorted);

/// Returns a look for each place whose lamps were found, in the order of the places' names.
std::vector<Look> looks_of(const std::vector<LampSight>& frames);

}  // namespace planar
