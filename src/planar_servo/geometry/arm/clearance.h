#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <string>
#include <vector>

namespace planar {

/// From where to where something reaches over the lamps' plane, metres; everywhere by default.
struct Heights {
  double from_m{-std::numeric_limits<double>::infinity()};
  double to_m{std::numeric_limits<double>::infinity()};

  bool overlap(const Heights& other) const { return from_m <= other.to_m && other.from_m <= to_m; }
};

/// What an arm takes up: each link a capsule about its axis, whose ends are base and elbow, or
/// elbow and end point; the tool with all it carries a disc about the end point. Metres.
struct ArmBody {
  Eigen::Vector2d link_widths_m{0.0, 0.0};
  std::array<Heights, 2> link_heights{};
  double tool_radius_m{0.0};
  Heights tool_heights{};
  /// What stays between arm and obstacles: for an arm that is not as its file says, and that brakes
  /// on the way.
  double clearance_m{5e-3};
};

/// Something fixed that no part of the arm may touch: a disc, or a polygon, with heights. Base
/// frame, metres.
struct Barrier {
  std::string name;
  std::vector<Eigen::Vector2d> corners_B;  ///< of the polygon; the only one is a disc's centre
  double radius_m{0.0};                    ///< of the disc
  Heights heights{};
};

/// Returns the distance from a segment to a barrier's edge; 0 where they overlap.
double distance_m(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Barrier& barrier);

/// Returns whether a polygon's edges meet only at its corners, and it has an area.
bool is_simple_polygon(const std::vector<Eigen::Vector2d>& corners);

/// The gap between the arm and the nearest barrier, less the clearance that must stay.
struct ArmGap {
  double gap_m{std::numeric_limits<double>::infinity()};
  const char* part{""};  ///< "link 1"
  std::size_t barrier{0};
};

/// Returns the smallest gap of an arm whose elbow and end point are there. Without barriers it is
/// infinite. `spared_m`, unless it is empty, has for each barrier how much nearer the arm may come.
ArmGap smallest_gap(const ArmBody& body, const std::vector<Barrier>& barriers,
                    const Eigen::Vector2d& elbow_B, const Eigen::Vector2d& end_B,
                    const std::vector<double>& spared_m = {});

}  // namespace planar
