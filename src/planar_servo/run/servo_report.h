#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/report/quiver_figure.h"
#include "planar_servo/run/servo_figures.h"
#include "planar_servo/run/servo_run.h"

namespace planar {

/// The figures under the keys of --json: before, after and improvement with the suffix of who
/// judged them, in millimetres.
nlohmann::json servo_json(const ServoFigures& figures);

/// The figures as lines for a terminal; the headline is `_truth` where there is one.
std::string servo_text(const ServoFigures& figures);

/// run.yaml: cell, targets and their hashes, settings, outcome.
std::string run_text(const ServoRequest& request, const ServoFigures& figures,
                     const std::vector<std::filesystem::path>& inputs);

/// An error at each target where it is known, under a title with its mean.
QuiverPanel error_panel(const std::string& what, const std::vector<TargetResult>& results,
                        TargetError error);

/// report.html of one run.
std::string servo_page(const ServoRequest& request, const std::vector<TargetResult>& results);

/// Writes run.yaml and report.html into the run's folder. The run used the files of its cell and
/// the table `targets`, which is empty when the targets came on standard input.
void write_run(const ServoRequest& request, const ServoFigures& figures,
               const std::vector<TargetResult>& results, const std::filesystem::path& targets);

}  // namespace planar
