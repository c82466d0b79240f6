#pragma once

#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/cell/finding.h"

namespace planar {

/// Questions a workspace that reaches out of the camera's field. No finding where all places that
/// the arm may go to are seen, nor before both the camera's and the workplane's file exist.
std::vector<Finding> question_camera_field(const CellSettings& cell);

}  // namespace planar
