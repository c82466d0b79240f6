#pragma once

#include <string>
#include <vector>

#include "planar_servo/files/tables/lay_table.h"

namespace planar {

/// Returns doubts in words where boards of known pitch are seen in another size than they have:
/// one when all seem to lie off the height that was stated, and one for each that seems to lie off
/// the others. The camera is this far above the dots' plane, metres.
std::vector<std::string> doubts_of_lays(const std::vector<LayRow>& lays, double camera_height);

}  // namespace planar
