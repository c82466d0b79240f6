#pragma once

#include <optional>
#include <string>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/arm/transmission.h"
#include "planar_servo/arm/workspace.h"

namespace planar {

/// Joint angles for a pose, or why there are none.
struct JointPlan {
  Joints theta{0.0, 0.0, 0.0};         ///< valid only without a refusal
  std::optional<std::string> refusal;  ///< in words, with the numbers
};

/// Decides where an arm may go, before anything moves: reach, workspace and motor limits together.
/// Throws std::invalid_argument for numbers that are not finite.
class JointPlanner {
 public:
  JointPlanner(const PlanarArm& arm, const Transmission& transmission, const Workspace& workspace,
               Elbow elbow);

  /// What forbids these joint angles; empty when nothing does.
  std::optional<std::string> refusal(const Joints& theta) const;

  /// The planner's elbow, and for each motor the turn within its limits nearest to `near`.
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
