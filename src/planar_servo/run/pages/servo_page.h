#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/run/servo_report.h"

namespace planar {

/// Returns the text of report.html of one run, which `ended_by` ended early, if anything: a verdict
/// with who judged, what else is known, the errors as arrows, and a row for each target.
std::string servo_page(const ServoRequest& request, const ServoFigures& figures,
                       const std::vector<TargetResult>& results,
                       const std::optional<std::string>& ended_by = {});

}  // namespace planar
