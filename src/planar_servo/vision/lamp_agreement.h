#pragma once

#include <cstddef>
#include <deque>

namespace planar {

/// Tells a change of the view from an arm that strays: a drop on the window displaces one lamp by
/// more than the other, an arm moves both. It compares a look's distance between the lamps and the
/// tool's direction, from that of the command, with those at the recent targets.
class LampAgreement {
 public:
  /// Takes a first look that nothing is wrong with: the lamps' distance, compensated, metres, and
  /// by how much the tool is turned from its command, radians.
  void take(double separation_m, double turn);

  /// Returns whether enough looks were taken to compare others with.
  bool knows() const { return turns_.size() >= kFewest; }
  /// Returns whether it is known that a look is as the recent ones were.
  bool agrees(double separation_m, double turn) const;

  static constexpr std::size_t kWindow = 40, kFewest = 5;

 private:
  std::deque<double> separations_m_, turns_;
};

}  // namespace planar
