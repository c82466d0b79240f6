#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace planar {

/// A disc, in the base frame, that the end point must not enter. Metres.
struct KeepOut {
  Eigen::Vector2d p_B{0.0, 0.0};
  double radius_m{0.0};
};

/// The region, in the base frame, in which the end point may be: a ring about the base without the
/// keep-out discs. Metres.
struct Workspace {
  double radius_min_m{0.0};
  double radius_max_m{0.0};
  std::vector<KeepOut> keep_out;

  /// Names the rule that forbids this end point, in words with the numbers; empty when none does.
  std::optional<std::string> violation(const Eigen::Vector2d& p_B) const;

  /// Returns how far the end point is outside the workspace, metres; 0 inside.
  double excess_m(const Eigen::Vector2d& p_B) const;
};

}  // namespace planar
