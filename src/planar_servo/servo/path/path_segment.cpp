#include "planar_servo/servo/path/path_segment.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// The least sine of the angle under which an arc's ends are seen from its point in between: an arc
/// of 1 degree.
constexpr double kLeastBend = 0.005;

/// Returns the centre of the circle through three points: it is as far from `a` as from b and c,
/// which is linear in the centre.
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

/// Returns the angle from one direction to another, turned in the sense of `sign`: above 0 and at
/// most a whole turn.
double turned(double from, double to, double sign) {
  const double angle = std::fmod(sign * (to - from) + 4.0 * kPi, 2.0 * kPi);
  return sign * angle;
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
  const double share = 0.5 + off / sweep_;
  return length_ * std::clamp(share, 0.0, 1.0);
}

}  // namespace planar
