#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "planar_servo/experiment/experiment.h"
#include "planar_servo/experiment/plots/plot_data.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/report/panel.h"

namespace planar {

/// A plot of the report, which is a file of its own as well.
struct ReportPlot {
  std::string file;  ///< the file's name
  std::string title;
  std::string caption;  ///< what it shows, on what data, and what to look at
  std::vector<Panel> panels;
};

/// Returns a plot that is a figure of the paper, named by its number there.
inline ReportPlot paper_plot(int number, const std::string& what, const std::string& caption,
                             std::vector<Panel> panels) {
  return {fmt::format("figure_{:02}.svg", number), fmt::format("Figure {}: {}", number, what),
          caption, std::move(panels)};
}

/// Returns those of the paper's Figures 6 to 16 for which there are data: edge points of the lamps,
/// the circles that are gone round several times, and the maps.
std::vector<ReportPlot> paper_plots(const PlotData& data);

/// Returns where the maps were learned beside the targets; none without training places.
std::vector<ReportPlot> coverage_plot(const ExperimentReport& report);

/// Returns the paper's Figures 18 and 19: the targets, and their true errors before and after.
std::vector<ReportPlot> control_plots(const ExperimentReport& report);

/// Returns histograms and cumulative curves of the true errors.
std::vector<ReportPlot> spread_plot(const ExperimentReport& report);

/// Returns the error by the servo's own view over the corrections, of both chains; none without
/// steps.
std::vector<ReportPlot> convergence_plot(const std::vector<StepError>& ours,
                                         const std::vector<StepError>& paper);

}  // namespace planar
