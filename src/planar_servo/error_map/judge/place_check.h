#pragma once

#include <vector>

#include "planar_servo/error_map/error_sample.h"
#include "planar_servo/error_map/fit/map_sites.h"
#include "planar_servo/error_map/judge/outlier_rule.h"

namespace planar {

/// Throws InputError naming each named place whose samples lie apart by more than a tenth of the
/// width of all positions: they say more of the field than their mean does. `sites` are the merged
/// samples.
void require_narrow_places(const std::vector<ErrorSample>& samples, const MapSites& sites);

/// Returns the samples that disagree with the others of their place, of which there must be two at
/// least; `Outlier::site` is the index of the sample. The limit is that of outlier_sigmas() for the
/// deviations within all places. Throws InputError when more than a fifth of the
/// samples do.
Outliers samples_unlike_their_place(const std::vector<ErrorSample>& samples, const MapSites& sites);

}  // namespace planar
