#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "planar_servo/arm/workspace.h"

namespace planar {

/// The radii of an experiment's circles, whole millimetres.
struct ExperimentCircles {
  std::array<int, 3> check_mm{150, 250, 350};     ///< of the paper's tables 2 and 5, about the base
  std::array<int, 4> run_mm{100, 200, 300, 400};  ///< of its Figures 7 to 11, about the base
  int sweep_mm{300};           ///< from the base to the end point while joint 3 turns
  int control_mm{200};         ///< of the four circles of table 7
  int rim_mm{20};              ///< the training disc ends this far inside the workspace
  int control_offset_mm{200};  ///< of their centres from the base, along each axis
};

/// Returns the circles for a workspace: the paper's ring, from 60 to 540 mm, is stretched to the
/// workspace's, and every circle keeps its place in it.
ExperimentCircles circles_within(const Workspace& workspace);

/// Returns equally spaced points of a circle, of which the first lies on the +x side.
std::vector<Eigen::Vector2d> circle_points(const Eigen::Vector2d& center, double radius, int count);

}  // namespace planar
