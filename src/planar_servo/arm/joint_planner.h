#pragma once

#include <optional>
#include <string>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/arm/workspace.h"

namespace planar {

/// Holds joint angles that reach a pose, or the reason why none do.
struct JointPlan {
  Joints theta{0.0, 0.0, 0.0};         ///< valid only without a refusal
  std::optional<std::string> refusal;  ///< the reason in words, with the numbers
};

/// Decides where an arm may go before anything moves. It checks reach, workspace and motor limits.
/// Throws std::invalid_argument for numbers that are not finite.
class JointPlanner {
 public:
  JointPlanner(const PlanarArm& arm, const Transmission& transmission, const Workspace& workspace,
               Elbow elbow);

  /// Returns the rule that forbids these joint angles, in words; empty when none does.
  std::optional<std::string> refusal(const Joints& theta) const;

  /// Returns the joint angles for `target` with the planner's elbow, each motor on the turn within
  /// its limits that lies nearest to `near`.
  JointPlan plan(const TipPose& target, const Joints& near) const;

  const PlanarArm& arm() const { return arm_; }
  const Transmission& transmission() const { return transmission_; }

 private:
  PlanarArm arm_;
  Transmission transmission_;
  Workspace workspace_;
  Elbow elbow_;
};

}  // namespace planar
