#pragma once

#include <string>
#include <vector>

#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/loop/servo/path/path.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"
#include "planar_servo/work/run/path_run.h"

namespace planar {

/// Adds to a page, as seen and, where a truth watched, as it was: the path with the looks beside
/// it, their deviation magnified by a stated factor; the deviation along the path; and the
/// deviation by speed. Panels of one kind share their axes; those without data are left out.
void add_path_plots(HtmlPage& page, const Path& path, const std::vector<PathLookRow>& looks,
                    const std::vector<PathSpeedResult>& results);

/// Returns the text of report.html of a path's run: a verdict with who judged, the deviation by
/// speed as a table, and the plots.
std::string path_page(const PathRequest& path, const std::vector<PathSpeedResult>& results,
                      const std::vector<PathLookRow>& looks);

/// Lists what the path demands of the arm.
ReportList path_demand_list(const PathRequest& path, const std::vector<PathDemand>& demands);

/// Returns whether a truth watched any of these.
bool is_judged(const std::vector<PathSpeedResult>& results);

/// Lists the deviation from the path by speed.
ReportList path_list(const PathRequest& path, const std::vector<PathSpeedResult>& results);

/// Writes run.yaml and report.html into the run's folder.
void write_path_run(const ServoRequest& request, const PathRequest& path, const PathRun& run);

}  // namespace planar
