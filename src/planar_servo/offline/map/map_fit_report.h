#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/error_map/judge/compare_methods.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"

namespace planar {

/// Returns what a fit found, what the pairs say of the cell, and how the methods compare, as lines
/// for a terminal.
std::string map_fit_text(const FitErrorMapReport& report,
                         const std::vector<MethodFigures>& comparison);

/// Returns the figures of a fit and of the comparison under the keys of --json.
nlohmann::json map_fit_json(const FitErrorMapReport& report,
                            const std::vector<MethodFigures>& comparison);

}  // namespace planar
