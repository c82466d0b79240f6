#include "planar_servo/loop/servo/path/path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// The least sine of the angle of an arc at its point in between: an arc of 1 degree.
constexpr double kLeastBend = 0.005;

/// Returns the centre of the circle through three points; equal distances are linear in it.
Eigen::Vector2d circle_center(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                              const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a, ac = c - a;
  const double d = 2.0 * cross2d(ab, ac);
  return a + Eigen::Vector2d(ac.y() * ab.squaredNorm() - ab.y() * ac.squaredNorm(),
                             ab.x() * ac.squaredNorm() - ac.x() * ab.squaredNorm()) /
                 d;
}

double angle_of(const Eigen::Vector2d& v) {
  return std::atan2(v.y(), v.x());
}

/// Returns the turn between directions in the sense of `sign`: above 0, at most a whole turn.
double turned(double from, double to, double sign) {
  return sign * std::fmod(sign * (to - from) + 4.0 * kPi, 2.0 * kPi);
}

/// A point belongs to a part of the path no farther than this from where it should be, metres.
constexpr double kNear_m = 0.010;

/// Two segments that meet at a smaller angle are passed without a rest.
constexpr double kSmoothJoint = 1.0 * kDegree;

double top_speed(const PathSegment& segment, double speed) {
  if (segment.curvature() == 0.0) return speed;
  return std::min(speed, std::sqrt(PathTiming::kAcceleration_m_s2 / segment.curvature()));
}

bool joined_smoothly(const PathSegment& before, const PathSegment& after) {
  const Eigen::Vector2d in = before.at(before.length_m()).tangent, out = after.at(0.0).tangent;
  return std::abs(std::atan2(cross2d(in, out), in.dot(out))) < kSmoothJoint;
}

/// Returns the speed at the beginning of each segment and at the end of the last one.
std::vector<double> joint_speeds(const Path& path, const std::vector<double>& tops) {
  const std::vector<PathSegment>& segments = path.segments();
  const std::size_t n = segments.size();
  std::vector<double> speeds(n + 1, 0.0);
  for (std::size_t i = 1; i < n; ++i)
    if (path.rests_s()[i - 1] == 0.0 && joined_smoothly(segments[i - 1], segments[i]))
      speeds[i] = std::min(tops[i - 1], tops[i]);
  const auto reachable = [&](double from, std::size_t i) {
    return std::sqrt(from * from + 2.0 * PathTiming::kAcceleration_m_s2 * segments[i].length_m());
  };
  for (std::size_t i = 0; i < n; ++i)
    speeds[i + 1] = std::min(speeds[i + 1], reachable(speeds[i], i));
  for (std::size_t i = n; i-- > 0;) speeds[i] = std::min(speeds[i], reachable(speeds[i + 1], i));
  return speeds;
}

}  // namespace

std::optional<const char*> arc_fault(const Eigen::Vector2d& from, const Eigen::Vector2d& via,
                                     const Eigen::Vector2d& to) {
  const Eigen::Vector2d in = via - from, out = to - via;
  if (std::min({in.norm(), out.norm(), (to - from).norm()}) < kSamePoint_m)
    return "an arc needs three places that differ; a whole circle takes two arcs";
  if (std::abs(cross2d(in, out)) < kLeastBend * in.norm() * out.norm())
    return "the three places of an arc must not lie on one line; leave the via columns empty to go "
           "straight";
  return std::nullopt;
}

PathSegment PathSegment::line(const TipPose& from, const TipPose& to) {
  PathSegment segment(from, to);
  segment.length_ = (to.p - from.p).norm();
  if (!(segment.length_ >= kSamePoint_m))
    throw std::invalid_argument("the ends of a line must be apart");
  return segment;
}

PathSegment PathSegment::arc(const TipPose& from, const Eigen::Vector2d& via, const TipPose& to) {
  if (const auto fault = arc_fault(from.p, via, to.p)) throw std::invalid_argument(*fault);
  PathSegment segment(from, to);
  segment.center_ = circle_center(from.p, via, to.p);
  const double sign = std::copysign(1.0, cross2d(via - from.p, to.p - via));
  segment.sweep_ =
      turned(angle_of(from.p - segment.center_), angle_of(to.p - segment.center_), sign);
  const double radius = (from.p - segment.center_).norm();
  segment.curvature_ = 1.0 / radius;
  segment.length_ = radius * std::abs(segment.sweep_);
  return segment;
}

PathPlace PathSegment::at(double along_m) const {
  const double share = std::clamp(along_m / length_, 0.0, 1.0);
  PathPlace place;
  place.pose.phi = from_.phi + share * (to_.phi - from_.phi);
  if (sweep_ == 0.0) {
    place.pose.p = from_.p + share * (to_.p - from_.p);
    place.tangent = (to_.p - from_.p) / length_;
    return place;
  }
  const Eigen::Vector2d radius = rotation2d(share * sweep_) * (from_.p - center_);
  place.pose.p = center_ + radius;
  place.tangent = std::copysign(curvature_, sweep_) * Eigen::Vector2d(-radius.y(), radius.x());
  return place;
}

double PathSegment::nearest_m(const Eigen::Vector2d& p_B) const {
  if (sweep_ == 0.0)
    return std::clamp((p_B - from_.p).dot(to_.p - from_.p) / length_, 0.0, length_);
  const double middle = angle_of(from_.p - center_) + 0.5 * sweep_;
  const double off = wrap_angle(angle_of(p_B - center_) - middle);
  return length_ * std::clamp(0.5 + off / sweep_, 0.0, 1.0);
}

Path::Path(const std::vector<Waypoint>& waypoints) : waypoints_(waypoints) {
  if (waypoints.size() < 2) throw std::invalid_argument("a path needs two places");
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    const TipPose &from = waypoints[i - 1].pose, &to = waypoints[i].pose;
    const auto& via = waypoints[i].via;
    segments_.push_back(via ? PathSegment::arc(from, *via, to) : PathSegment::line(from, to));
    begins_.push_back(begins_.back() + segments_.back().length_m());
    rests_s_.push_back(waypoints[i].rest_s);
  }
}

PathPlace Path::at(double along_m) const {
  const auto next = std::upper_bound(begins_.begin() + 1, begins_.end() - 1, along_m);
  const auto i = static_cast<std::size_t>(next - begins_.begin()) - 1;
  return segments_[i].at(along_m - begins_[i]);
}

PathOffset Path::offset(const Eigen::Vector2d& p_B, double near_m) const {
  std::optional<PathOffset> nearest;
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (begins_[i] > near_m + kNear_m || begins_[i + 1] < near_m - kNear_m) continue;
    const double along_m = segments_[i].nearest_m(p_B);
    const PathPlace place = segments_[i].at(along_m);
    const Eigen::Vector2d off = p_B - place.pose.p;
    if (nearest && off.norm() >= std::abs(nearest->across_m)) continue;
    const double side = cross2d(place.tangent, off) < 0.0 ? -1.0 : 1.0;
    nearest = {begins_[i] + along_m, side * off.norm()};
  }
  return nearest.value_or(PathOffset{});
}

std::vector<Eigen::Vector2d> drawn_places(const Path& path) {
  constexpr double kTurn = 0.05;  // of an arc between two of them, radians
  std::vector<Eigen::Vector2d> places{path.at(0.0).pose.p};
  for (const PathSegment& segment : path.segments()) {
    const double turn = segment.curvature() * segment.length_m();
    const int lines = 1 + static_cast<int>(turn / kTurn);
    for (int i = 1; i <= lines; ++i)
      places.push_back(segment.at(segment.length_m() * i / lines).pose.p);
  }
  return places;
}

PathTiming::PathTiming(const Path& path, double speed_m_s) {
  if (!(speed_m_s > 0.0) || !std::isfinite(speed_m_s))
    throw std::invalid_argument("a path's speed must be positive");
  std::vector<double> tops;
  for (const PathSegment& segment : path.segments()) tops.push_back(top_speed(segment, speed_m_s));
  const std::vector<double> speeds = joint_speeds(path, tops);
  for (std::size_t i = 0; i < tops.size(); ++i) {
    append(path.segments()[i].length_m(), speeds[i], speeds[i + 1], tops[i]);
    append_phase(path.rests_s()[i], 0.0, 0.0);
  }
}

void PathTiming::append(double length_m, double from, double to, double top) {
  const double a = kAcceleration_m_s2;
  const double peak = std::min(top, std::sqrt(a * length_m + 0.5 * (from * from + to * to)));
  const double ramps_m = (2.0 * peak * peak - from * from - to * to) / (2.0 * a);
  append_phase((peak - from) / a, from, a);
  append_phase(std::max(0.0, length_m - ramps_m) / peak, peak, 0.0);
  append_phase((peak - to) / a, peak, -a);
}

void PathTiming::append_phase(double duration_s, double speed_m_s, double acceleration_m_s2) {
  phases_.push_back({end_s_, end_m_, speed_m_s, acceleration_m_s2});
  end_m_ += (speed_m_s + 0.5 * acceleration_m_s2 * duration_s) * duration_s;
  end_s_ += duration_s;
}

double PathTiming::along_m(double t_s) const {
  if (t_s >= end_s_) return end_m_;
  const auto next =
      std::upper_bound(phases_.begin() + 1, phases_.end(), t_s,
                       [](double t, const Phase& phase) { return t < phase.begin_s; });
  const Phase& phase = *(next - 1);
  const double dt = std::max(0.0, t_s - phase.begin_s);
  return phase.begin_m + (phase.speed_m_s + 0.5 * phase.acceleration_m_s2 * dt) * dt;
}

}  // namespace planar
