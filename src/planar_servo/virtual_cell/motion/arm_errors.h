#pragma once

#include <Eigen/Core>

#include "planar_servo/virtual_cell/truth/arm_truth.h"

namespace planar {

// The forms of what an arm's axes and links do besides. Angles of joints do not start anew after a
// turn.

/// Returns where an axis stands at this angle of its joint, in the frame of the link before,
/// metres. `size_m` is how far it goes once per turn, in a circle that is passed unevenly; cage and
/// balls of the bearing, whose orders are no whole numbers, add two fifths of that.
Eigen::Vector2d runout_m(double joint_rad, double size_m, double phase_rad);

/// Returns the part of it that turns with the joint.
Eigen::Vector2d turning_runout_m(double joint_rad, double size_m, double phase_rad);

/// Returns the lean of an axis that turns unevenly with its joint, as the x and y of a rotation
/// vector in the frame of the link before.
Eigen::Vector2d wobble_rad(double joint_rad, double size_rad, double phase_rad);

/// Returns by how much the tool stands higher where the tip is at `p_B`.
double height_wave_m(const HeightWaveTruth& wave, const Eigen::Vector2d& p_B);

/// Returns the displacement of the tip when link 1 and link 2 have these directions: the cables of
/// the base pull at link 1, most at a radian from where they are slack and less beyond; those of
/// the elbow pull at link 2, one way when it is stretched and the other way when it is bent.
Eigen::Vector2d bending_m(const BendingTruth& bending, double link1_rad, double link2_rad);

}  // namespace planar
