#include "planar_servo/geometry/arm/planar_arm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Rounding may put a point at the edge of the reach this far outside, relative to the reach.
constexpr double kRimRounding = 1e-12;

constexpr Named<ReachStatus> kReachStatuses[] = {
    {ReachStatus::kOk, "within reach"},
    {ReachStatus::kTooFar,
     "out of reach: the point lies farther from the base than both links together reach"},
    {ReachStatus::kTooClose,
     "out of reach: the point lies nearer to the base than the difference of the links' lengths"},
    {ReachStatus::kUndetermined,
     "the point lies on the base's axis, where joint 1 is not determined"}};

template <typename Vector>
void require_finite(const Vector& values, const char* what) {
  if (!values.allFinite()) throw std::invalid_argument(std::string(what) + " must be finite");
}

ReachStatus reach_status(double r, double L1, double L2) {
  const double rounding = kRimRounding * (L1 + L2);
  if (r > L1 + L2 + rounding) return ReachStatus::kTooFar;
  if (r < std::abs(L1 - L2) - rounding) return ReachStatus::kTooClose;
  if (r <= rounding) return ReachStatus::kUndetermined;
  return ReachStatus::kOk;
}

/// Returns four times the area of the triangle with these sides, by Heron's formula; 0 where
/// rounding leaves no triangle.
double four_areas(double a, double b, double c) {
  const double product = (a + b + c) * (a + b - c) * (a - b + c) * (b + c - a);
  return std::sqrt(std::max(product, 0.0));
}

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

/// Returns a disc round a barrier.
KeepOut disc_round(const Barrier& barrier) {
  KeepOut around{Eigen::Vector2d::Zero(), barrier.radius_m};
  for (const Eigen::Vector2d& corner : barrier.corners_B) around.p_B += corner;
  around.p_B /= static_cast<double>(barrier.corners_B.size());
  for (const Eigen::Vector2d& corner : barrier.corners_B)
    around.radius_m = std::max(around.radius_m, (corner - around.p_B).norm());
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
    const KeepOut around = disc_round(barriers[i]);
    for (const Part& part : parts) {
      if (!part.heights.overlap(barriers[i].heights)) continue;
      const double spared = spared_m.empty() ? 0.0 : spared_m[i];
      const double kept_m = part.radius_m + body.clearance_m - spared;
      if (point_to_segment(around.p_B, part.from, part.to) - around.radius_m - kept_m >=
          smallest.gap_m)
        continue;
      const double gap = distance_m(part.from, part.to, barriers[i]) - kept_m;
      if (gap < smallest.gap_m) smallest = {gap, part.name, i};
    }
  }
  return smallest;
}

std::optional<std::string> Workspace::violation(const Eigen::Vector2d& p_B) const {
  const double radius = p_B.norm();
  if (!(radius >= radius_min_m && radius <= radius_max_m))
    return fmt::format(
        "{} is {:.3f} mm from the base; the workspace reaches from {:.3f} to {:.3f} mm",
        place_mm(p_B), mm(radius), mm(radius_min_m), mm(radius_max_m));
  for (const KeepOut& disc : keep_out)
    if ((p_B - disc.p_B).norm() < disc.radius_m)
      return fmt::format("{} lies in the keep-out disc of {:.3f} mm about {}", place_mm(p_B),
                         mm(disc.radius_m), place_mm(disc.p_B));
  return std::nullopt;
}

std::vector<Border> Workspace::borders() const {
  std::vector<Border> borders{
      {Eigen::Vector2d::Zero(), radius_min_m, true, "beyond the inner border of the workspace"},
      {Eigen::Vector2d::Zero(), radius_max_m, false, "beyond the outer border of the workspace"}};
  for (const KeepOut& disc : keep_out)
    borders.push_back({disc.p_B, disc.radius_m, true, "into the keep-out disc"});
  return borders;
}

double Workspace::excess_m(const Eigen::Vector2d& p_B) const {
  double excess = 0.0;
  for (const Border& border : borders()) excess = std::max(excess, border.depth_m(p_B));
  return excess;
}

const char* describe(ReachStatus status) {
  return name_in(kReachStatuses, status);
}

PlanarArm::PlanarArm(const ArmGeometry& geometry)
    : geometry_(geometry),
      sense_(geometry.positive_rotation == Rotation::kCounterclockwise ? 1.0 : -1.0) {
  require_finite(geometry.link_lengths_m, "link lengths");
  if (geometry.link_lengths_m.minCoeff() <= 0.0)
    throw std::invalid_argument("link lengths must be positive");
}

TipPose PlanarArm::forward(const Joints& theta) const {
  require_finite(theta, "joint angles");
  const Eigen::Vector2d& L = geometry_.link_lengths_m;
  return {{L[0] * std::cos(theta[0]) + L[1] * std::cos(theta[1]),
           sense_ * (L[0] * std::sin(theta[0]) + L[1] * std::sin(theta[1]))},
          sense_ * theta[2]};
}

Eigen::Vector2d PlanarArm::elbow_place(const Joints& theta) const {
  return geometry_.link_lengths_m[0] *
         Eigen::Vector2d(std::cos(theta[0]), sense_ * std::sin(theta[0]));
}

InverseResult PlanarArm::inverse(const TipPose& target, Elbow elbow, const Joints& near) const {
  require_finite(target.p, "target position");
  require_finite(Eigen::Matrix<double, 1, 1>(target.phi), "target direction");
  require_finite(near, "present joint angles");
  const double L1 = geometry_.link_lengths_m[0];
  const double L2 = geometry_.link_lengths_m[1];
  const double r = target.p.norm();
  const ReachStatus status = reach_status(r, L1, L2);
  if (status != ReachStatus::kOk) return {status, {}};

  const double f = std::atan2(sense_ * target.p.y(), target.p.x());
  // alpha and gamma follow from the law of cosines. Each cosine is divided by its sine in atan2,
  // because acos loses digits where the arm is nearly stretched or folded.
  const double sine = four_areas(r, L1, L2);
  const double alpha = std::atan2(sine, r * r + L1 * L1 - L2 * L2);
  const double gamma = std::atan2(sine, r * r + L2 * L2 - L1 * L1);
  const double e = elbow == Elbow::kRight ? sense_ : -sense_;
  return {ReachStatus::kOk,
          {nearest_branch(f - e * alpha, near[0]), nearest_branch(f + e * gamma, near[1]),
           nearest_branch(sense_ * target.phi, near[2])}};
}

Elbow PlanarArm::elbow(const Joints& theta) const {
  require_finite(theta, "joint angles");
  return sense_ * std::sin(theta[1] - theta[0]) > 0.0 ? Elbow::kRight : Elbow::kLeft;
}

Eigen::Matrix2d PlanarArm::jacobian(const Joints& theta) const {
  require_finite(theta, "joint angles");
  const double L1 = geometry_.link_lengths_m[0];
  const double L2 = geometry_.link_lengths_m[1];
  Eigen::Matrix2d J;
  J << -L1 * std::sin(theta[0]), -L2 * std::sin(theta[1]),  //
      sense_ * L1 * std::cos(theta[0]), sense_ * L2 * std::cos(theta[1]);
  return J;
}

double PlanarArm::manipulability(const Joints& theta) {
  require_finite(theta, "joint angles");
  return std::abs(std::sin(theta[1] - theta[0]));
}

}  // namespace planar
