#pragma once

#include "planar_servo/core/units.h"

namespace planar {

// Units of truth.yaml that cell.yaml does not need.
constexpr double kHour = 3600.0;
constexpr double kArcSecond = kDegree / 3600.0;
constexpr double kMicroradian = 1e-6;
constexpr double kFullStep = 1.8 * kDegree;  ///< of a stepper motor with 200 steps per turn

}  // namespace planar
