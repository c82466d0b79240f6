#pragma once

#include <string>
#include <vector>

#include "planar_servo/report/html_page.h"
#include "planar_servo/run/path_run.h"
#include "planar_servo/servo/path/path.h"
#include "planar_servo/tables/path_tables.h"

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

}  // namespace planar
