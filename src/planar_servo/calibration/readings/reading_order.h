#pragma once

#include <vector>

#include "planar_servo/calibration/pairing.h"

namespace planar {

/// Throws InputError when the readings do not belong to the places that they are given to. Pixels
/// and direction of the lamps determine the reflector's place by a smooth view, a cubic, which
/// misses half of the places by less than two hundredths of the field. Where it misses more and the
/// pairing is by id, rows shifted by up to three places are tried; the error names the shift with
/// which the readings follow the lamps. Where none helps, only readings missed by a quarter of the
/// field are refused, because no camera bends the plane by that. Too few places say nothing.
void require_reading_order(const std::vector<ToolSight>& sights, PairBy by);

/// Takes out places at which the tracker gave the very reading of the place before, although the
/// lamps had moved. Returns each with the reason.
std::vector<Rejection> take_out_frozen(std::vector<ToolSight>& sights);

}  // namespace planar
