#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/work/run/servo_report.h"

namespace planar {

/// Returns the text of report.html of one run, ended early by `ended_by` unless that is empty: the
/// verdict and who judged, other figures, the errors as arrows, and a row for each target.
std::string servo_page(const std::filesystem::path& cell_file, const ServoFigures& figures,
                       const std::vector<TargetResult>& results,
                       const std::optional<std::string>& ended_by = {});

}  // namespace planar
