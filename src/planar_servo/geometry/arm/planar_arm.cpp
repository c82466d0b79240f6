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

}  // namespace

std::optional<std::string> Workspace::violation(const Eigen::Vector2d& p_B) const {
  const double radius = p_B.norm();
  if (!(radius >= radius_min_m && radius <= radius_max_m))
    return fmt::format(
        "{} is {:.3f} mm from the base; the workspace reaches from {:.3f} to {:.3f} mm",
        place_mm(p_B), radius / kMillimetre, mm(radius_min_m), mm(radius_max_m));
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
