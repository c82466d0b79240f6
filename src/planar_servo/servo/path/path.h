#pragma once

#include <optional>
#include <vector>

#include "planar_servo/servo/path/path_segment.h"

namespace planar {

/// Holds a place that a path goes through, in the base frame: straight from the place before it, or
/// on the arc through `via`. The first place begins the path and has no `via`.
struct Waypoint {
  TipPose pose;
  std::optional<Eigen::Vector2d> via{};
};

/// Says where a point lies, seen from a path.
struct PathOffset {
  double along_m{0.0};   ///< how far along the path its nearest point lies
  double across_m{0.0};  ///< distance from there, positive on the left of the way
};

/// A way of the end point through the plane, in lines and arcs one after the other, measured by its
/// length from the beginning.
class Path {
 public:
  /// Throws std::invalid_argument for fewer than two places and for what PathSegment refuses.
  explicit Path(const std::vector<Waypoint>& waypoints);

  double length_m() const { return begins_.back(); }
  const std::vector<PathSegment>& segments() const { return segments_; }
  /// Returns how far along the path segment `i` begins; segments().size() gives the path's length.
  double begin_m(std::size_t i) const { return begins_.at(i); }

  /// Returns the place so far along the path; beyond an end, that end.
  PathPlace at(double along_m) const;

  /// Returns where a point lies, seen from the part of the path about `near_m`. The path may cross
  /// itself elsewhere.
  PathOffset offset(const Eigen::Vector2d& p_B, double near_m) const;

 private:
  std::vector<PathSegment> segments_;
  std::vector<double> begins_{0.0};
};

}  // namespace planar
