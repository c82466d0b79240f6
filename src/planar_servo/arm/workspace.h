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

/// One border of a workspace: a circle, in the base frame, that the end point must not enter, or
/// must not leave. Metres.
struct Border {
  Eigen::Vector2d p_B;
  double radius_m;
  bool forbidden_inside;
  const char* words;  ///< "beyond the inner border of the workspace"

  /// Returns how deep a point lies on the forbidden side; negative on the other side. Where a point
  /// moves by some distance, its depth changes by no more than that.
  double depth_m(const Eigen::Vector2d& point_B) const {
    const double inside = radius_m - (point_B - p_B).norm();
    return forbidden_inside ? inside : -inside;
  }
};

/// The region, in the base frame, in which the end point may be: a ring about the base without the
/// keep-out discs. Metres.
struct Workspace {
  double radius_min_m{0.0};
  double radius_max_m{0.0};
  std::vector<KeepOut> keep_out;

  /// Names the rule that forbids this end point, in words with the numbers; empty when none does.
  std::optional<std::string> violation(const Eigen::Vector2d& p_B) const;

  /// Returns the ring's two borders, then those of the keep-out discs.
  std::vector<Border> borders() const;

  /// Returns how far the end point is outside the workspace, metres; 0 inside.
  double excess_m(const Eigen::Vector2d& p_B) const;
};

}  // namespace planar
