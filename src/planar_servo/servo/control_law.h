#pragma once

#include <Eigen/Core>

#include "planar_servo/arm/planar_arm.h"

namespace planar {

enum class LawStatus {
  kOk,
  kSingular,     ///< the links are within 3 degrees of being in line
  kUnreachable,  ///< the inverse law's measured or desired point is out of reach
};

/// In words, for messages.
const char* describe(LawStatus status);

/// The step of joints 1 and 2 that a law asks for, radians.
struct LawStep {
  LawStatus status{LawStatus::kOk};
  Eigen::Vector2d delta_theta{0.0, 0.0};  ///< valid only when status is kOk
};

/// Where a law starts from: joints as commanded, end point as measured and as desired, base frame.
struct LawInput {
  Joints theta{0.0, 0.0, 0.0};
  Eigen::Vector2d p{0.0, 0.0};
  Eigen::Vector2d p_d{0.0, 0.0};
};

/// Delta theta = lambda J^+ (p_d - p), by ViSP's vpServo. lambda is `gain` at the target and falls
/// to half of it far away (vpAdaptiveGain over the step x in radians: its slope at 0 is -gain, as
/// the linear model's relative error grows like x).
LawStep jacobian_law(const PlanarArm& arm, const LawInput& input, double gain);

/// Delta theta = gain (theta(p_d) - theta(p)) by the inverse kinematics with the present elbow; the
/// paper's law when `gain` is 1.
LawStep inverse_law(const PlanarArm& arm, const LawInput& input, double gain);

}  // namespace planar
