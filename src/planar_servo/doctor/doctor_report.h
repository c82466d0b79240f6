#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/cell/finding.h"

namespace planar {

/// True when nothing that was found is faulty.
bool is_sound(const std::vector<Finding>& findings);

/// A line for each finding, and one for its remedy.
std::string findings_text(const std::vector<Finding>& findings);

/// The findings under the key of --json.
nlohmann::json findings_json(const std::vector<Finding>& findings);

}  // namespace planar
