#pragma once

#include <vector>

#include "planar_servo/files/path/path_run_tables.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/servo/path/path.h"

namespace planar {

/// Adds to a page, each as seen and where a truth watched as it was: the path with the looks beside
/// it, their deviation magnified by a factor that is stated; the deviation along the path; and the
/// deviation by speed. Panels of one kind share their axes. What nobody saw is left out.
void add_path_figures(HtmlPage& page, const Path& path, const std::vector<PathLookRow>& looks,
                      const std::vector<PathSpeedResult>& results);

}  // namespace planar
