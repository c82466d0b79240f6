#pragma once

#include <optional>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/io/columns.h"

namespace planar {

/// Visits the columns theta1_deg, theta2_deg and theta3_deg, which a table may lack and a row may
/// leave empty. A row that has only some of them is at fault.
void list_joints(Columns& columns, std::optional<Joints>& theta);

}  // namespace planar
