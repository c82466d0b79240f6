#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"

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
  std::vector<Barrier> barriers{};  ///< what no part of the arm may touch

  /// Names the rule that forbids this end point, in words with the numbers; empty when none does.
  std::optional<std::string> violation(const Eigen::Vector2d& p_B) const;

  /// Returns the ring's two borders, then those of the keep-out discs.
  std::vector<Border> borders() const;

  /// Returns how far the end point is outside the workspace, metres; 0 inside.
  double excess_m(const Eigen::Vector2d& p_B) const;
};

/// Joint angles theta1, theta2, theta3, radians. All are measured from the base's x axis: theta2 is
/// the absolute direction of link 2, theta3 that of the tool.
using Joints = Eigen::Vector3d;

/// The sense in which joint angles grow, seen from +z.
enum class Rotation { kCounterclockwise, kClockwise };

/// The side of the ray from the base to P on which the elbow lies, seen from +z.
enum class Elbow { kLeft, kRight };

struct ArmGeometry {
  Eigen::Vector2d link_lengths_m{0.3, 0.3};
  Rotation positive_rotation{Rotation::kCounterclockwise};
  ArmBody body{};  ///< asked for only where there are barriers
};

enum class ReachStatus {
  kOk,
  kTooFar,        ///< |p| > L1 + L2
  kTooClose,      ///< |p| < |L1 - L2|
  kUndetermined,  ///< p is on the base's axis and the links are equally long: any theta1 would do
};

/// Describes the status in words, with the rule, for messages.
const char* describe(ReachStatus status);

struct InverseResult {
  ReachStatus status{ReachStatus::kOk};
  Joints theta{0.0, 0.0, 0.0};  ///< valid only when status is kOk
};

/// Computes the kinematics of two links in a plane and a tool that turns about their end P, in the
/// base frame B:
///   x = L1 cos(theta1) + L2 cos(theta2),  y = s (L1 sin(theta1) + L2 sin(theta2)),
///   phi = s theta3,  with s = +1 where angles grow from x to y, else -1.
/// Every function throws std::invalid_argument for a number that is not finite.
class PlanarArm {
 public:
  /// Throws std::invalid_argument unless both lengths are finite and positive.
  explicit PlanarArm(const ArmGeometry& geometry);

  TipPose forward(const Joints& theta) const;

  /// Returns the solution with the given elbow, each angle on the 2 pi branch nearest to `near`.
  /// Where the arm is stretched both elbows have the same solution.
  InverseResult inverse(const TipPose& target, Elbow elbow, const Joints& near) const;

  Elbow elbow(const Joints& theta) const;
  Eigen::Vector2d elbow_place(const Joints& theta) const;  ///< base frame

  /// Returns d(x, y) / d(theta1, theta2), metres per radian.
  Eigen::Matrix2d jacobian(const Joints& theta) const;

  /// Returns |sin(theta2 - theta1)|: 1 where the links are at a right angle, 0 where the arm is
  /// singular.
  static double manipulability(const Joints& theta);

  /// Returns s of the equations, +1 or -1.
  double sense() const { return sense_; }
  const ArmGeometry& geometry() const { return geometry_; }

 private:
  ArmGeometry geometry_;
  double sense_;
};

}  // namespace planar
