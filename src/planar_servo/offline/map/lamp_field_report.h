#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/field/fit_lamp_field.h"

namespace planar {

/// Returns what a fit of field and arm found, what fixed it and how places left out are met, as
/// lines for a terminal.
std::string lamp_field_report_text(const LampFieldFit& fit);

/// Returns the figures of such a fit under the keys of --json.
nlohmann::json lamp_field_report_json(const LampFieldFit& fit);

}  // namespace planar
