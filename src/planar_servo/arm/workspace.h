#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace planar {

struct KeepOut {
  Eigen::Vector2d p_B{0.0, 0.0};
  double radius_m{0.0};
};

/// Where the end point may be sent, in the base frame.
struct Workspace {
  double radius_min_m{0.0};
  double radius_max_m{0.0};
  std::vector<KeepOut> keep_out;  ///< discs that the end point must not enter

  /// What forbids this end point, in words with the numbers; empty when nothing does.
  std::optional<std::string> violation(const Eigen::Vector2d& p_B) const;

  /// How far the end point is beyond what is allowed, metres; 0 inside.
  double excess_m(const Eigen::Vector2d& p_B) const;
};

}  // namespace planar
