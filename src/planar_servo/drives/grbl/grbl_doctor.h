#pragma once

#include <vector>

#include "planar_servo/cell/finding.h"
#include "planar_servo/drives/grbl/grbl_settings.h"

namespace planar {

/// The board's port, the permission to use it, its firmware, settings and state. The board is reset
/// for it, by which it forgets its position; nothing moves.
std::vector<Finding> examine_grbl(const GrblSettings& settings);

}  // namespace planar
