#pragma once

#include <Eigen/Geometry>
#include <string>

#include "planar_servo/drives/grbl/grbl_protocol.h"
#include "planar_servo/drives/grbl/jog_path.h"

namespace planar {

/// What is believed of a board's reports. Grbl's lines have no checksum, so that a single report
/// may be garbled: a place off the way, a pressed or released input is believed when the next
/// report says the same. The way is a box that holds all places where the axes may be.
class GrblWatch {
 public:
  explicit GrblWatch(const Eigen::Vector3d& pulses_per_mm);

  void take(const grbl::Report& report);
  /// Returns whether garbage must end a move. Garbled reports must when there are several in a row.
  bool minds(const grbl::Garbage& garbage);

  grbl::State state() const { return report_.state; }
  bool turns() const { return report_.turns; }
  /// Returns whether the axes turn, have slowed down and did not speed up since.
  bool slows() const { return slows_; }
  /// Returns whether the board has said where it is.
  bool knows_place() const { return knows_place_; }
  const AxisPulses& here() const { return here_; }
  /// Returns false when the axes are off their way, as far as there is one.
  bool on_way() const { return way_.isEmpty() || on_way(here_); }
  /// Returns whether the last report was of a place on the way.
  bool settled() const { return !off_way_seen_; }
  /// Says where the axes are instead of on their way.
  std::string off_way_words() const;

  void extend_way(const AxisPulses& place) { way_.extend(place); }
  /// The axes rest where they are.
  void end_way() { way_ = Eigen::AlignedBox3i(here_); }
  /// The next place that is reported is believed.
  void forget_way();

  /// A move begins: inputs that are pressed now do not count until they were released.
  void begin_move() { pressed_from_start_ = pressed_ + report_.pins; }
  /// Returns whether the input of an axis 'X' to 'Z' was pressed since then.
  bool newly_pressed(char axis) const;

 private:
  void take_pins(const std::string& previous);
  void take_place(const std::array<double, 3>& position_mm);
  bool on_way(const AxisPulses& place) const;

  Eigen::Vector3d pulses_per_mm_;
  grbl::Report report_;
  AxisPulses here_{0, 0, 0};
  bool knows_place_{false}, off_way_seen_{false}, slows_{false};
  Eigen::AlignedBox3i way_;
  std::string pressed_, pressed_from_start_;  ///< letters of axes
  int garbled_reports_{0};
};

}  // namespace planar
