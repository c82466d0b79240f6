#pragma once

#include <vector>

#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"
#include "planar_servo/run/path_run.h"
#include "planar_servo/servo/path/path.h"
#include "planar_servo/tables/path_tables.h"

namespace planar {

/// Adds to a page, each as seen and where a truth watched as it was: the path with the looks beside
/// it, their deviation magnified by a factor that is stated; the deviation along the path; and the
/// deviation by speed. Panels of one kind share their axes. What nobody saw is left out.
void add_path_plots(HtmlPage& page, const Path& path, const std::vector<PathLookRow>& looks,
                    const std::vector<PathSpeedResult>& results);

/// Lists what the path asks of the arm.
ReportList path_demand_list(const PathRequest& path, const std::vector<PathDemand>& demands);

/// Lists the deviation from the path by speed.
ReportList path_list(const PathRequest& path, const std::vector<PathSpeedResult>& results);

/// Returns the same as a table.
TextTable path_table(const PathRequest& path, const std::vector<PathSpeedResult>& results);

/// Writes run.yaml and report.html into the run's folder.
void write_path_run(const ServoRequest& request, const PathRequest& path, const PathRun& run);

}  // namespace planar
