#pragma once

#include <cstddef>
#include <vector>

#include "planar_servo/calibration/pairing.h"

namespace planar {

/// Returns the readings in order of time. Of a tracker that reads continuously, only those taken
/// while the reflector rested.
std::vector<ToolReading> readings_at_rest(std::vector<ToolReading> readings);

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
