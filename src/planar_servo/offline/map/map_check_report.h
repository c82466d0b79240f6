#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/offline/map/check_error_map.h"

namespace planar {

/// How a map does on other pairs, as a table for a terminal; `n_left_out` pairs were of other
/// plans.
std::string map_check_text(const MapCheck& check, std::size_t n_left_out);

/// The same figures under the keys of --json.
nlohmann::json map_check_json(const MapCheck& check);

}  // namespace planar
