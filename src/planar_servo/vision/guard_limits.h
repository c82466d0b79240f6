#pragma once

#include "planar_servo/arm/workspace.h"
#include "planar_servo/servo/motion_guard.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Returns the limits of a cell whose vision is calibrated. With an error map, a correction may be
/// half as long again as the longest that the map makes within its valid region and the workspace,
/// for a tool of direction `phi`.
GuardLimits guard_limits(const VisionCalibration& vision, const Workspace& workspace, double phi);

}  // namespace planar
