#pragma once

#include <array>
#include <vector>

#include "planar_servo/arm/transmission.h"
#include "planar_servo/cell/finding.h"
#include "planar_servo/drives/tic/tic_drives.h"

namespace planar {

/// Presence, permission, firmware, settings, supply and errors of every Tic, and whether the speeds
/// of the transmission are within what a Tic can do. Nothing moves and nothing is switched on.
std::vector<Finding> examine_tics(const TransmissionSettings& transmission,
                                  const std::array<TicSettings, 3>& tics);

}  // namespace planar
