#pragma once

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/arm/workspace.h"
#include "planar_servo/health/cause.h"
#include "planar_servo/servo/motion_guard.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Returns the model of what a calibrated camera sees of an arm that is as the cell's files state.
/// `home` are the joints at which its motors count from their marks or switches.
CellModel model_of_cell(const JointPlanner& planner, const Joints& home,
                        const VisionCalibration& vision);

/// Returns the limits of a cell whose vision is calibrated. With an error map, a correction may be
/// up to 1.5 times as long as the longest that the map makes within its valid region and the
/// workspace, for a tool of direction `phi`.
GuardLimits guard_limits(const VisionCalibration& vision, const Workspace& workspace, double phi);

}  // namespace planar
