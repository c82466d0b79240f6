#pragma once

#include <vector>

#include "planar_servo/error_map/error_sample.h"
#include "planar_servo/error_map/fit/map_sites.h"

namespace planar {

/// Gives samples that lie close together a place of their own, if the positions fall into such
/// groups: in the shortest tree that joins all positions, lengths within a place and between places
/// then differ by a factor of two at least. Returns the samples unchanged if they do not, as on a
/// grid, on rings or at random positions, and beyond five thousand positions. `sites` are the
/// samples merged by position; no sample names a place.
std::vector<ErrorSample> with_found_places(std::vector<ErrorSample> samples, const MapSites& sites);

}  // namespace planar
