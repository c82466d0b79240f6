#pragma once

#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Draws the length by which something is off, metres: 0 except for the share of outliers.
double stray_length(const OutlierTruth& outliers, Random& random);

}  // namespace planar
