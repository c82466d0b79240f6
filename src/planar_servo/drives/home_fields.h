#pragma once

#include <string>

#include "planar_servo/arm/transmission.h"

namespace planar {

class Fields;

/// Lists the key `home` of an item of `drives`: where a motor's position is counted from.
void list_home(Fields& drive, MotorDrive& motor);

/// Returns that key, with comments, for a motor in a new cell file that is moved to a mark by hand.
std::string new_home(double mark_deg);

}  // namespace planar
