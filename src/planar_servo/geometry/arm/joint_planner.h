#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/geometry/arm/found_arm.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/arm/transmission.h"

namespace planar {

/// Holds joint angles that reach a pose, or the reason why none do.
struct JointPlan {
  Joints theta{0.0, 0.0, 0.0};         ///< valid only without a refusal
  std::optional<std::string> refusal;  ///< the reason in words, with the numbers
};

/// Decides where an arm may go before anything moves. It checks reach, workspace and motor limits,
/// at the end and on the way there. Throws std::invalid_argument for numbers that are not finite.
class JointPlanner {
 public:
  /// With an `approach_margin` (radians), plan() leaves every motor that much more room below.
  JointPlanner(const PlanarArm& arm, const Transmission& transmission, const Workspace& workspace,
               Elbow elbow, double approach_margin = 0.0);

  /// Lets plan() return the joint angles to command so that an arm as it was found reaches the
  /// target. Everything else stays with the arm as its files have it.
  void plan_for(FoundArm found);

  /// Returns the rule that forbids these joint angles, in words; empty when none does.
  std::optional<std::string> refusal(const Joints& theta) const;

  /// Returns why the end point must not take the way from rest at some joint angles to rest at
  /// others, on which all motors begin at once; empty when it may.
  /// Nowhere may the way lead more than kWayResolution_m deeper beyond a border of the workspace
  /// than where it begins, so that an arm that stands in a keep-out disc can leave it. To barriers
  /// the clearance stays, and half of it while the arm brakes, whenever it is stopped.
  std::optional<std::string> way_refusal(const Joints& from, const Joints& to) const;

  /// Returns the rests of a way from one rest to another, the last of which is `to`: one where the
  /// straight way is allowed, else more where a way round the barriers is found. Empty where there
  /// is none. The tool keeps its direction until the last of them.
  std::vector<Joints> way_round(const Joints& from, const Joints& to) const;

  /// Returns places of the end point on the straight way between two rests, to draw it.
  std::vector<Eigen::Vector2d> drawn_way(const Joints& from, const Joints& to) const;

  /// Depths on a way are known to this, metres: a hundredth of a millimetre.
  static constexpr double kWayResolution_m{1e-5};

  /// Returns the joint angles for `target` with the planner's elbow, each motor on the turn within
  /// its limits that lies nearest to `near`. Turns are preferred that leave room for corrections.
  JointPlan plan(const TipPose& target, const Joints& near) const;

  /// Returns where these commanded joints bring the end point, by the arm as it was found. It
  /// undoes plan().
  TipPose reached(const Joints& commanded) const;

  /// Returns that arm, with the sense, the coupling and the gears of the files.
  const std::optional<FoundArm>& found() const { return found_; }
  /// Returns its scatter, and by how much its base moves; 0 where no arm was found.
  double scatter_m() const { return found_ ? found_->scatter_m : 0.0; }
  double wander_m() const { return found_ ? found_->wander_m : 0.0; }
  /// Returns the joint angles, near `theta`, by which the arm as it was found stands at a pose with
  /// this elbow. It refuses where reached() would not undo them.
  JointPlan plan_as_found(const TipPose& pose, Joints theta, Elbow elbow) const;
  bool has_barriers() const { return !workspace_.barriers.empty(); }
  const PlanarArm& arm() const { return arm_; }
  const Transmission& transmission() const { return transmission_; }

 private:
  ArmGap gap(const Joints& theta, const std::vector<double>& spared_m = {}) const;
  /// Returns by how much the arm is too near to each barrier; nothing where it is to none.
  std::vector<double> overlaps_m(const Joints& theta) const;
  /// Returns how far the arm is from the nearest barrier or border, negative beyond it; minus
  /// infinity outside the limits of the motors.
  double room_m(const Joints& theta) const;
  /// Leaves out rests between which the straight way is allowed; the first is where the arm stands.
  /// Empty where even the next one is not.
  std::vector<Joints> shortened(const std::vector<Joints>& rests) const;
  /// Returns why the way between two rests is forbidden to an arm that is not stopped on it.
  std::optional<std::string> sweep_refusal(const Joints& from, const Joints& to) const;
  /// Returns why no way leads on from there for an arm whose axes stand within a barrier, where
  /// "no nearer" would allow every way through it; empty elsewhere.
  std::optional<std::string> refusal_within(const Joints& theta) const;
  /// Says in words which part touches which barrier there.
  std::string touching(const Joints& theta, const std::vector<double>& spared_m = {}) const;

  PlanarArm arm_;
  Transmission transmission_;
  Workspace workspace_;
  Elbow elbow_;
  double approach_margin_;
  std::optional<FoundArm> found_;
};

}  // namespace planar
