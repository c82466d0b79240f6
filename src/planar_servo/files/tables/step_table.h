#pragma once

#include <string>

#include "planar_servo/servo/position_servo.h"

namespace planar {

// The table steps.csv grows: the header first, then a line at a time.

std::string steps_header();
/// Returns the line of one step on the way to the target `id`.
std::string step_line(const std::string& id, const ServoStep& step);

}  // namespace planar
