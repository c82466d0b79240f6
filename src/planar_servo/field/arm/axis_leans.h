#pragma once

#include <vector>

#include "planar_servo/field/arm/arm_model.h"
#include "planar_servo/field/pose_sample.h"

namespace planar {

/// Returns what is known of the leans of an arm's axes: how they are built, and what the heights of
/// the reflector tell where the tracker read them. A lean that displaces the reflector by d at its
/// height h over the lamps lowers what the axis carries by d . q / h, at the place q from the axis.
AxisLeans axis_leans(const ArmNominal& nominal, const std::vector<PoseSample>& samples);

}  // namespace planar
