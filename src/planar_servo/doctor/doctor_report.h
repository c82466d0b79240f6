#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/cell/finding.h"

namespace planar {

/// Returns true when nothing that was found is faulty.
bool is_sound(const std::vector<Finding>& findings);

/// Returns a line for each finding, and one for its remedy.
std::string findings_text(const std::vector<Finding>& findings);

/// Returns the findings under the keys of --json.
nlohmann::json findings_json(const std::vector<Finding>& findings);

}  // namespace planar
