#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/tracker_table.h"

namespace planar {

/// How readings of one place or monument scatter, per axis.
struct RestSpread {
  double rms{0.0}, stated{0.0};  ///< metres
  int freedom{0};                ///< 0 where no two readings share a place
};

/// Returns the spread of readings that share an id.
RestSpread rest_spread(const std::vector<TrackerRow>& readings, const TrackerSettings& tracker);

/// Returns whether readings scatter by clearly more than the cell file states.
bool is_shaking(const RestSpread& spread);

/// Says so.
std::string doubt_of_rest(const RestSpread& spread);

/// Returns the settings with a deviation by which readings scatter as they do.
TrackerSettings with_found_scatter(TrackerSettings tracker, const RestSpread& spread);

}  // namespace planar
