#pragma once

#include <array>
#include <optional>
#include <vector>

#include "planar_servo/health/cause.h"
#include "planar_servo/lamps/lamp_look.h"

namespace planar {

/// Holds between what values the looks of one lamp lay over a whole calibration.
struct LookRange {
  LampLook least, most;
};

/// The ranges of lamps 1 and 2.
using LookRanges = std::array<LookRange, 2>;

/// Returns the ranges of these looks, as far as they were measured; nothing without any look.
std::optional<LookRanges> ranges_of(const std::vector<LampLooks>& looks);

/// Finds what has changed in light or focus since the calibration: the first of background,
/// brightness, blur and roundness in which the mean look of a lamp lies outside its range by more
/// than the range is wide. A place in the field costs no more than that, because the range holds
/// all places of a recording. `cost_m` is how far the tool is seen from where it was.
std::optional<HealthFinding> find_light_change(const LookRanges& then,
                                               const std::vector<LampLooks>& now, double cost_m);

}  // namespace planar
