#include "planar_servo/arm/workspace.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {

std::optional<std::string> Workspace::violation(const Eigen::Vector2d& p_B) const {
  const double radius = p_B.norm();
  if (!(radius >= radius_min_m && radius <= radius_max_m))
    return fmt::format(
        "{} is {:.3f} mm from the base; the workspace reaches from "
        "{:.3f} to {:.3f} mm",
        place_mm(p_B), radius / kMillimetre, radius_min_m / kMillimetre,
        radius_max_m / kMillimetre);
  for (const KeepOut& disc : keep_out)
    if ((p_B - disc.p_B).norm() < disc.radius_m)
      return fmt::format("{} lies in the keep-out disc of {:.3f} mm about {}", place_mm(p_B),
                         disc.radius_m / kMillimetre, place_mm(disc.p_B));
  return std::nullopt;
}

double Workspace::excess_m(const Eigen::Vector2d& p_B) const {
  const double radius = p_B.norm();
  double excess = std::max({0.0, radius_min_m - radius, radius - radius_max_m});
  for (const KeepOut& disc : keep_out)
    excess = std::max(excess, disc.radius_m - (p_B - disc.p_B).norm());
  return excess;
}

}  // namespace planar
