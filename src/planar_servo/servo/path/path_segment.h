#pragma once

#include <Eigen/Core>
#include <optional>

#include "planar_servo/core/plane_geometry.h"

namespace planar {

/// Holds a place on a path, in the base frame: the pose there, and the unit vector of travel.
struct PathPlace {
  TipPose pose;
  Eigen::Vector2d tangent{1.0, 0.0};
};

/// A straight line or an arc of a circle in the base frame, metres. The tool's direction turns
/// evenly on the way.
class PathSegment {
 public:
  /// Goes straight. Throws std::invalid_argument unless the ends are apart.
  static PathSegment line(const TipPose& from, const TipPose& to);

  /// Goes on the circle through `from`, `via` and `to`. Throws std::invalid_argument unless no two
  /// of them are the same and they do not lie on one line.
  static PathSegment arc(const TipPose& from, const Eigen::Vector2d& via, const TipPose& to);

  double length_m() const { return length_; }
  /// Returns 1 / radius; 0 for a line.
  double curvature() const { return curvature_; }

  /// Returns the place so far along the segment; beyond an end, that end.
  PathPlace at(double along_m) const;

  /// Returns how far along the segment its point lies that is nearest to `p_B`.
  double nearest_m(const Eigen::Vector2d& p_B) const;

 private:
  PathSegment(const TipPose& from, const TipPose& to) : from_(from), to_(to) {}

  TipPose from_, to_;
  double length_{0.0}, curvature_{0.0};
  Eigen::Vector2d center_{0.0, 0.0};
  double sweep_{0.0};  ///< angle of an arc about its centre, positive from x to y
};

/// Points nearer to one another than this are the same, metres.
constexpr double kSamePoint_m = 1e-6;

/// Says why there is no arc through three points, in words; empty when there is one.
std::optional<const char*> arc_fault(const Eigen::Vector2d& from, const Eigen::Vector2d& via,
                                     const Eigen::Vector2d& to);

}  // namespace planar
