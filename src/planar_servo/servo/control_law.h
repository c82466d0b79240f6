#pragma once

#include <Eigen/Core>

#include "planar_servo/arm/planar_arm.h"

namespace planar {

/// Says whether a law gave a step.
enum class LawStatus {
  kOk,
  kSingular,     ///< the links are within 3 degrees of being in line
  kUnreachable,  ///< the inverse law's measured or desired point is out of reach
};

/// Returns the status in words, for messages.
const char* describe(LawStatus status);

/// Holds a law's step of joints 1 and 2, radians.
struct LawStep {
  LawStatus status{LawStatus::kOk};
  Eigen::Vector2d delta_theta{0.0, 0.0};  ///< valid only when status is kOk
};

/// Holds what a law starts from: the commanded joints (radians), and the measured and the desired
/// end point in the base frame (metres).
struct LawInput {
  Joints theta{0.0, 0.0, 0.0};
  Eigen::Vector2d p{0.0, 0.0};
  Eigen::Vector2d p_d{0.0, 0.0};
};

/// Computes the step J^+ (p_d - p) times a gain lambda, by ViSP's vpServo. lambda is `gain` at the
/// target and falls to half of it far away. This is vpAdaptiveGain of the step x in radians; its
/// slope at 0 is -gain, as the relative error of the linear model grows like x.
LawStep jacobian_law(const PlanarArm& arm, const LawInput& input, double gain);

/// Computes the step gain (theta(p_d) - theta(p)) by the inverse kinematics with the present elbow.
/// With a gain of 1 it is the paper's law.
LawStep inverse_law(const PlanarArm& arm, const LawInput& input, double gain);

}  // namespace planar
