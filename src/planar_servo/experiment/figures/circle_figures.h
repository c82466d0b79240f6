#pragma once

#include <vector>

#include "planar_servo/experiment/figures/figure_data.h"
#include "planar_servo/experiment/figures/report_figure.h"

namespace planar {

/// Returns the paper's Figures 7 to 11, on the circles that are gone round several times: where
/// they are, by how much vision and tracker find the arm beside the plan, by how much they differ,
/// and how alike that is between the runs. None without places.
std::vector<ReportFigure> circle_figures(const std::vector<CirclePlace>& places);

}  // namespace planar
