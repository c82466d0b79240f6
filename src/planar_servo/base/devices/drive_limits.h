#pragma once

#include <array>

#include "planar_servo/base/devices/drive_group.h"

namespace planar {

/// Throws InputError for limits that are not positive, or beyond those of the cell's motors.
void require_within(const std::array<DriveLimits, 3>& limits,
                    const std::array<DriveLimits, 3>& rated);

}  // namespace planar
