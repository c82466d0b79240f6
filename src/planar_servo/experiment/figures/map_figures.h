#pragma once

#include <vector>

#include "planar_servo/experiment/figures/figure_data.h"
#include "planar_servo/experiment/figures/report_figure.h"

namespace planar {

/// Returns the paper's Figures 13 to 16: the vision error at the training places, over the field as
/// inverse distance weighting and as radial basis functions predict it, and measured against
/// predicted along the check circles.
std::vector<ReportFigure> map_figures(const FigureData& data);

}  // namespace planar
