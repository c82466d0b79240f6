#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/offline/map/check_error_map.h"

namespace planar {

/// Returns how a map does on other pairs, as a table for a terminal. `n_left_out` is the number of
/// pairs of other plans.
std::string map_check_text(const MapCheck& check, std::size_t n_left_out);

/// Returns the figures of a check under the keys of --json.
nlohmann::json map_check_json(const MapCheck& check);

}  // namespace planar
