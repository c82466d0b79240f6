#pragma once

#include "planar_servo/io/fields.h"
#include "planar_servo/virtual_cell/truth/arm_truth.h"

namespace planar {

/// Visits the keys of the block `arm` that say what is wrong with the arm.
void list_fields(Fields& fields, ArmTruth& arm);

}  // namespace planar
