#pragma once

#include <string>

#include "planar_servo/experiment/experiment.h"

namespace planar {

/// Returns the errors before and after at the control targets as one SVG.
std::string experiment_figure(const ExperimentReport& report);

/// Returns the text of report.html.
std::string experiment_page(const ExperimentReport& report, const std::string& cell_name);

}  // namespace planar
