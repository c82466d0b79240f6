#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

namespace planar {

/// Tells for how long a board has stood still: its points, seen again and again, lie within a bound
/// of where they are now (root of the mean square distance).
class BoardRest {
 public:
  explicit BoardRest(double bound_px) : bound_px_(bound_px) {}

  /// Takes the points of the board as seen at this time, which never goes back; none when it is
  /// not seen.
  void see(double t_s, const std::vector<Eigen::Vector2d>& pixels);

  /// Returns the seconds, up to ten, for which it has stood still; 0 unless it was seen twice.
  double still_for_s() const;

 private:
  struct Seen {
    double t_s;
    std::vector<Eigen::Vector2d> pixels;
  };

  double bound_px_;
  std::deque<Seen> seen_;  ///< while it stands still; the newest last
};

}  // namespace planar
