#pragma once

#include <deque>
#include <optional>
#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/files/tables/tracker_lines.h"

namespace planar {

/// Decides when a stream of readings has come to rest. The reflector rests when its readings over
/// half a second, at least five of them, scatter by no more than half as much again as the cell's
/// `tracker.sigma_mm` states (rms per axis); their mean is the reading.
class RestWindow {
 public:
  explicit RestWindow(const TrackerSettings& tracker) : tracker_(tracker) {}

  /// Takes the next reading, which arrived at this time on the computer's clock.
  void add(const StreamedReading& reading, double arrived_s);

  /// Returns the mean reading at rest, whose time is the tracker's or, where it tells none, that of
  /// arrival.
  std::optional<TrackerReading> at_rest() const;

  /// Returns true when all readings are the same to the last digit, although that digit is finer
  /// than the noise.
  bool is_frozen() const;

  /// Says by how much the readings scatter, and by how much they may.
  std::string scatter_text() const;

 private:
  struct Arrived {
    StreamedReading reading;
    double arrived_s;
  };

  bool is_full() const;
  Eigen::Vector3d mean() const;
  double scatter() const;
  double bound() const;

  TrackerSettings tracker_;
  std::deque<Arrived> window_;
};

}  // namespace planar
