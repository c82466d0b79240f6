#pragma once

#include <string>

#include "planar_servo/servo/position_servo.h"

namespace planar {

// steps.csv, a table that grows: the header first, then a line at a time.

std::string steps_header();
/// One step on the way to the target `id`.
std::string step_line(const std::string& id, const ServoStep& step);

}  // namespace planar
