#pragma once

#include <optional>
#include <vector>

#include "planar_servo/experiment/figures/figure_data.h"
#include "planar_servo/experiment/figures/report_figure.h"

namespace planar {

/// Returns the paper's Figure 6: edge points and fitted circles of both lamps; none without lamps.
std::optional<ReportFigure> lamp_figure(const std::vector<LampEdges>& lamps);

}  // namespace planar
