#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/health/health_record.h"

namespace planar {

/// Returns how fast the camera's picture drifted while a recording was made, metres per second in
/// the base frame, by places with the same commanded joints that were visited at different times.
/// Zero where none was or where chance explains what they show.
Eigen::Vector2d recorded_drift(const std::vector<SeenPlace>& seen);

/// Moves places of a recording to where they would be seen at its end.
void bring_to_end(const std::vector<SeenPlace>& seen, std::vector<HealthPlace>& places);

}  // namespace planar
