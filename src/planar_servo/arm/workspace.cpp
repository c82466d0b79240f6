#include "planar_servo/arm/workspace.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/text.h"
#include "planar_servo/core/units.h"

namespace planar {

std::optional<std::string> Workspace::violation(const Eigen::Vector2d& p_B) const {
  const double radius = p_B.norm();
  if (!(radius >= radius_min_m && radius <= radius_max_m))
    return fmt::format(
        "{} is {:.3f} mm from the base; the workspace reaches from "
        "{:.3f} to {:.3f} mm",
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

}  // namespace planar
