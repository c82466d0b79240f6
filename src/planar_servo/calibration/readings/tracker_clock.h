#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "planar_servo/calibration/pairing.h"

namespace planar {

/// A stretch of time, on one clock.
struct TimeSpan {
  double begin_s{0.0}, end_s{0.0};
  double middle_s() const { return 0.5 * (begin_s + end_s); }
  double length_s() const { return end_s - begin_s; }
};

/// A rest of the reflector.
struct Rest {
  TimeSpan span;  ///< on the tracker's clock
  Eigen::Vector3d p_B{0.0, 0.0, 0.0};
};

/// A look of the camera at the resting tool.
struct Look {
  TimeSpan span;  ///< on the camera's clock
  std::array<Eigen::Vector2d, 2> lamps_px;
};

/// Returns the readings in order of time. Of a tracker that reads continuously, only those taken
/// while the reflector rested.
std::vector<ToolReading> readings_at_rest(std::vector<ToolReading> readings);

/// Returns where the reflector rested, in order of time. `sorted` are the readings of
/// readings_at_rest().
std::vector<Rest> rests_of(const std::vector<ToolReading>& sorted);

/// Returns a look for each place whose lamps were found, in the order of the places' names.
std::vector<Look> looks_of(const std::vector<LampSight>& frames);

/// The tracker's clock relative to the camera's: it shows t + offset_s + rate (t - middle_s) when
/// the camera's shows t.
struct TrackerClock {
  double offset_s{0.0};  ///< in the middle of the recording
  double rate{0.0};      ///< tracker's seconds per camera's second, less one
  double middle_s{0.0};  ///< of the recording, on the camera's clock
  double sigma_offset_s{0.0};
  double sigma_rate{0.0};
  std::size_t places{0};  ///< places by which the clocks were compared

  /// Returns what the camera's clock shows when the tracker's shows `t_s`.
  double camera_time_s(double t_s) const {
    return middle_s + (t_s - offset_s - middle_s) / (1.0 + rate);
  }
};

/// Relates the tracker's clock to the camera's, by the times at which the reflector rested and
/// those at which the camera saw the tool at rest. `readings` are those of readings_at_rest(). Of
/// the clocks that match rests with places, it returns the one with which the reflector follows the
/// lamps, by an affine view of their middle and direction. Throws InputError when there is none,
/// when several fit equally well, and when the clock would run too fast or slow by more than a
/// thousandth.
TrackerClock estimate_tracker_clock(const std::vector<LampSight>& frames,
                                    const std::vector<ToolReading>& readings);

}  // namespace planar
