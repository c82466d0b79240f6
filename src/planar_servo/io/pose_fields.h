#pragma once

#include "planar_servo/core/pose.h"
#include "planar_servo/io/fields.h"

namespace planar {

/// Visits the keys translation_mm and quaternion_wxyz of a pose (metres). Returns whether they make
/// a pose: the quaternion must have length 1 to within 0.001, the rounding of a few digits.
bool list_pose(Fields& fields, Pose& pose);

}  // namespace planar
