#pragma once

#include <vector>

#include "planar_servo/report/report_list.h"
#include "planar_servo/run/path_run.h"
#include "planar_servo/servo/path/path.h"
#include "planar_servo/tables/path_tables.h"

namespace planar {

/// Lists what the path demands of the arm.
ReportList path_demand_list(const PathRequest& path, const std::vector<PathDemand>& demands);

/// Returns whether a truth watched any of these.
bool is_judged(const std::vector<PathSpeedResult>& results);

/// Lists the deviation from the path by speed.
ReportList path_list(const PathRequest& path, const std::vector<PathSpeedResult>& results);

/// Returns the same as a table.
TextTable path_table(const PathRequest& path, const std::vector<PathSpeedResult>& results);

/// Writes run.yaml and report.html into the run's folder.
void write_path_run(const ServoRequest& request, const PathRequest& path, const PathRun& run);

}  // namespace planar
