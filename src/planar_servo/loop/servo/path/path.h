#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/base/core/pose.h"

namespace planar {

/// Holds a place on a path, in the base frame: the pose there, and the unit vector of travel.
struct PathPlace {
  TipPose pose;
  Eigen::Vector2d tangent{1.0, 0.0};
};

/// A line or an arc in the base frame, metres. The tool's direction turns evenly on the way.
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
  /// Returns the place at this distance along the segment; beyond an end, that end.
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

/// Holds a place that a path goes through, in the base frame: straight from the place before it, or
/// on the arc through `via`. The first place begins the path and has no `via`.
struct Waypoint {
  TipPose pose;
  std::optional<Eigen::Vector2d> via{};
  double rest_s{0.0};  ///< for which the end point waits there
};

/// Says where a point lies, seen from a path.
struct PathOffset {
  double along_m{0.0};   ///< how far along the path its nearest point lies
  double across_m{0.0};  ///< distance from there, positive on the left of the way
};

/// A way of the end point in lines and arcs, measured by its length from the beginning.
class Path {
 public:
  /// Throws std::invalid_argument for fewer than two places and for what PathSegment refuses.
  explicit Path(const std::vector<Waypoint>& waypoints);

  double length_m() const { return begins_.back(); }
  const std::vector<PathSegment>& segments() const { return segments_; }
  const std::vector<Waypoint>& waypoints() const { return waypoints_; }
  /// Returns for how long the end point waits behind each segment, seconds.
  const std::vector<double>& rests_s() const { return rests_s_; }
  /// Returns the place at this distance along the path; beyond an end, that end.
  PathPlace at(double along_m) const;
  /// Returns where a point lies, seen from the path about `near_m`, which may cross itself.
  PathOffset offset(const Eigen::Vector2d& p_B, double near_m) const;

 private:
  std::vector<Waypoint> waypoints_;
  std::vector<PathSegment> segments_;
  std::vector<double> begins_{0.0}, rests_s_;
};

/// Returns places to draw a path by, with straight lines between them.
std::vector<Eigen::Vector2d> drawn_places(const Path& path);

/// Says when the end point is where on its path: it begins and ends at rest, and speeds up and
/// slows down evenly. At a corner it rests for a moment; on an arc it goes so slowly that
/// v^2 / radius keeps the acceleration. Where the path says so, it waits longer.
class PathTiming {
 public:
  /// Throws std::invalid_argument unless the speed is positive.
  PathTiming(const Path& path, double speed_m_s);

  /// The acceleration: 50 mm/s is reached after 0.5 s and 12.5 mm.
  static constexpr double kAcceleration_m_s2{0.1};

  double duration_s() const { return end_s_; }
  /// Returns how far along the path the end point is at a time; 0 before, all of it after.
  double along_m(double t_s) const;

 private:
  struct Phase {
    double begin_s, begin_m, speed_m_s, acceleration_m_s2;
  };
  /// Appends a way of `length_m` from one speed to another, at most at `top`, metres and seconds.
  void append(double length_m, double from, double to, double top);
  void append_phase(double duration_s, double speed_m_s, double acceleration_m_s2);

  std::vector<Phase> phases_;
  double end_s_{0.0}, end_m_{0.0};
};

}  // namespace planar
