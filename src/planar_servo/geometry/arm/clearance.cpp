#include "planar_servo/geometry/arm/clearance.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/pose.h"

namespace planar {
namespace {

double point_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                        const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double square = along.squaredNorm();
  const double t = square > 0.0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

/// Returns whether two segments cross or touch.
bool meet(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
          const Eigen::Vector2d& d) {
  const auto side = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q,
                       const Eigen::Vector2d& r) { return cross2d(q - p, r - p); };
  return side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0 &&
         (side(a, b, c) != 0.0 || side(a, b, d) != 0.0);
}

double segment_to_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                          const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
  if (meet(a, b, c, d)) return 0.0;
  return std::min({point_to_segment(a, c, d), point_to_segment(b, c, d), point_to_segment(c, a, b),
                   point_to_segment(d, a, b)});
}

bool contains(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

/// A disc round a barrier.
struct Surroundings {
  Eigen::Vector2d center_B;
  double radius_m;
};

Surroundings surroundings_of(const Barrier& barrier) {
  Surroundings around{Eigen::Vector2d::Zero(), barrier.radius_m};
  for (const Eigen::Vector2d& corner : barrier.corners_B) around.center_B += corner;
  around.center_B /= static_cast<double>(barrier.corners_B.size());
  for (const Eigen::Vector2d& corner : barrier.corners_B)
    around.radius_m = std::max(around.radius_m, (corner - around.center_B).norm());
  return around;
}

}  // namespace

double distance_m(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Barrier& barrier) {
  const auto& corners = barrier.corners_B;
  if (corners.size() == 1)
    return std::max(0.0, point_to_segment(corners[0], from, to) - barrier.radius_m);
  if (contains(corners, from)) return 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i)
    nearest = std::min(nearest,
                       segment_to_segment(from, to, corners[i], corners[(i + 1) % corners.size()]));
  return nearest;
}

bool is_simple_polygon(const std::vector<Eigen::Vector2d>& corners) {
  const std::size_t n = corners.size();
  if (n < 3) return false;
  double area = 0.0;
  for (std::size_t i = 0; i < n; ++i) area += cross2d(corners[i], corners[(i + 1) % n]);
  if (std::abs(area) < 1e-12) return false;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      const bool neighbours = i == 0 && j == n - 1;
      if (!neighbours && meet(corners[i], corners[i + 1], corners[j], corners[(j + 1) % n]))
        return false;
    }
  return true;
}

ArmGap smallest_gap(const ArmBody& body, const std::vector<Barrier>& barriers,
                    const Eigen::Vector2d& elbow_B, const Eigen::Vector2d& end_B,
                    const std::vector<double>& spared_m) {
  struct Part {
    const char* name;
    Eigen::Vector2d from, to;
    double radius_m;
    Heights heights;
  };
  const Eigen::Vector2d base = Eigen::Vector2d::Zero();
  const Part parts[] = {
      {"link 1", base, elbow_B, 0.5 * body.link_widths_m[0], body.link_heights[0]},
      {"link 2", elbow_B, end_B, 0.5 * body.link_widths_m[1], body.link_heights[1]},
      {"the tool", end_B, end_B, body.tool_radius_m, body.tool_heights}};
  ArmGap smallest;
  for (std::size_t i = 0; i < barriers.size(); ++i) {
    const Surroundings around = surroundings_of(barriers[i]);
    for (const Part& part : parts) {
      if (!part.heights.overlap(barriers[i].heights)) continue;
      const double spared = spared_m.empty() ? 0.0 : spared_m[i];
      const double kept_m = part.radius_m + body.clearance_m - spared;
      if (point_to_segment(around.center_B, part.from, part.to) - around.radius_m - kept_m >=
          smallest.gap_m)
        continue;
      const double gap = distance_m(part.from, part.to, barriers[i]) - kept_m;
      if (gap < smallest.gap_m) smallest = {gap, part.name, i};
    }
  }
  return smallest;
}

}  // namespace planar
