#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace planar {

/// Positions of a board's axes X, Y, Z, pulses.
using AxisPulses = Eigen::Vector3i;

/// The limits of one axis of a board, in its lengths.
struct AxisLimits {
  double pulses_per_mm{250.0};
  double speed_mm_s{0.0};
  double acceleration_mm_s2{0.0};
};

/// Returns how far beyond a position that is passed at `speed` a motion may be queued so that, left
/// alone, it ends within `duration`. It speeds up to at most `top_speed` and ends at rest. All in
/// one unit of length and time.
double reach(double speed, double top_speed, double acceleration, double duration);

/// A straight way of a board's axes, handed out in short pieces as it is travelled, so that the
/// board never has more in its queue than it travels in grbl::kLongestRun_s.
class JogPath {
 public:
  JogPath(const AxisPulses& from, const AxisPulses& to, const std::array<AxisLimits, 3>& limits);

  /// Returns the end of the next piece, given where the axes are. Empty while enough is queued and
  /// once all is sent.
  std::optional<AxisPulses> next_piece(const AxisPulses& here);

  /// Returns the end of the last piece that was handed out.
  const AxisPulses& sent() const { return sent_; }
  bool all_sent() const { return sent_ == to_; }
  double speed_mm_s() const { return speed_; }
  /// Returns whether a target can be reached from here, by the end of the last piece, without any
  /// axis turning back.
  bool leads_to(const AxisPulses& target, const AxisPulses& here) const;

 private:
  Eigen::Vector3d in_mm(const AxisPulses& pulses) const;

  AxisPulses from_, to_, sent_;
  Eigen::Vector3d pulses_per_mm_;
  Eigen::Vector3d direction_{0.0, 0.0, 0.0};
  double length_{0.0}, speed_{0.0}, acceleration_{0.0};  // mm and seconds
  double sent_length_{0.0};
};

}  // namespace planar
