#pragma once

#include <string>
#include <vector>

#include "planar_servo/report/html_page.h"
#include "planar_servo/report/quiver_figure.h"
#include "planar_servo/report/report_list.h"
#include "planar_servo/run/servo_figures.h"
#include "planar_servo/run/servo_run.h"

namespace planar {

/// Lists the figures, those against the truth first where there are any. The keys before, after and
/// improvement have the suffix of who judged them.
ReportList servo_list(const ServoFigures& figures);

/// Returns where the arm alone landed, in the mean, and where it ended with vision, by who judged;
/// a clause. Stated intervals that hold too little or too much are mentioned. Empty where nothing
/// was measured.
std::string landing_words(const ServoFigures& figures);

/// Says what is wrong with a run by its figures: targets that were not reached, and vision that
/// made the arm worse. `results` says where each target's reason stands.
std::vector<Verdict::Fault> run_faults(const ServoFigures& figures, const std::string& results);

/// Returns a panel with an error at each target where it is known, under a title with its mean.
QuiverPanel error_panel(const std::string& what, const std::vector<TargetResult>& results,
                        TargetError error);

/// Returns the text of report.html of one run.
std::string servo_page(const ServoRequest& request, const std::vector<TargetResult>& results);

/// Returns the files that a run uses: those of its cell, and what it moves to or along, if that is
/// a file.
std::vector<std::filesystem::path> run_inputs(const ServoRequest& request,
                                              const std::filesystem::path& wanted);

/// Writes run.yaml and report.html into the run's folder. The run used the files of its cell and
/// the table `targets`, which is empty when the targets came on standard input.
void write_run(const ServoRequest& request, const ServoRun& run, const ServoFigures& figures,
               const std::filesystem::path& targets);

}  // namespace planar
