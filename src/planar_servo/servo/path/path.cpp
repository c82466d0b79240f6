#include "planar_servo/servo/path/path.h"

#include <algorithm>
#include <stdexcept>

namespace planar {
namespace {

/// A point belongs to a part of the path no farther than this from where it should be, metres.
constexpr double kNear_m = 0.010;

}  // namespace

Path::Path(const std::vector<Waypoint>& waypoints) {
  if (waypoints.size() < 2) throw std::invalid_argument("a path needs two places");
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    const TipPose &from = waypoints[i - 1].pose, &to = waypoints[i].pose;
    const auto& via = waypoints[i].via;
    segments_.push_back(via ? PathSegment::arc(from, *via, to) : PathSegment::line(from, to));
    begins_.push_back(begins_.back() + segments_.back().length_m());
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

}  // namespace planar
