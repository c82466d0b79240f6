#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/experiment/experiment.h"
#include "planar_servo/experiment/figures/report_figure.h"

namespace planar {

/// Returns the errors before and after at the control targets as one SVG.
std::string experiment_figure(const ExperimentReport& report);

/// Returns the figures of the report: those of the paper that the data allow, in its order, and
/// before them how the errors are spread and how the loop converges. The steps of the latter are
/// read from the runs in `out`.
std::vector<ReportFigure> experiment_figures(const ExperimentReport& report,
                                             const std::filesystem::path& out);

/// Returns the text of a page about the experiment. It links to those files in `out` that exist.
std::string experiment_page(const ExperimentReport& report, const std::string& cell_name,
                            const std::vector<ReportFigure>& figures,
                            const std::filesystem::path& out);

/// Writes errors.svg, figures/*.svg, figures.json and report.html to `out`, and returns the path of
/// the page.
std::filesystem::path write_experiment_report(const ExperimentReport& report,
                                              const std::string& cell_name,
                                              const std::filesystem::path& out);

}  // namespace planar
