#pragma once

#include <optional>
#include <vector>

#include "planar_servo/experiment/experiment.h"
#include "planar_servo/experiment/figures/report_figure.h"
#include "planar_servo/files/tables/step_table.h"

namespace planar {

/// Returns the paper's Figures 18 and 19: the targets, and their true errors before and after.
std::vector<ReportFigure> control_figures(const ExperimentReport& report);

/// Returns histograms and cumulative curves of the true errors.
std::optional<ReportFigure> spread_figure(const ExperimentReport& report);

/// Returns the error by the servo's own view over the corrections, of both chains; none without
/// steps.
std::optional<ReportFigure> convergence_figure(const std::vector<StepError>& ours,
                                               const std::vector<StepError>& paper);

}  // namespace planar
