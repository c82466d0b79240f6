#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/experiment/experiment.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Lists every figure of an experiment; its text says what the tables do not say.
ReportList experiment_list(const ExperimentReport& report);

/// Lists what the calibration alone predicts.
ReportList prediction_list(const PositioningPrediction& prediction);

/// Returns the tables and the list for a terminal.
std::string experiment_text(const ExperimentReport& report);

/// Writes errors.svg, figures/*.svg, figures.json and report.html to `out`, and returns the path of
/// the page. It links to those files in `out` that exist.
std::filesystem::path write_experiment_report(const ExperimentReport& report,
                                              const std::string& cell_name,
                                              const std::filesystem::path& out);

}  // namespace planar
