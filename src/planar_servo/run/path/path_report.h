#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/run/path/path_run.h"

namespace planar {

/// Returns what the path asks of the arm as lines for a terminal, and under the keys of --json.
std::string path_demand_text(const PathRequest& path, const std::vector<PathDemand>& demands);
nlohmann::json path_demand_json(const PathRequest& path, const std::vector<PathDemand>& demands);

/// Returns the deviation from the path by speed as a table for a terminal.
std::string path_text(const PathRequest& path, const std::vector<PathSpeedResult>& results);

/// Returns the figures under the keys of --json.
nlohmann::json path_json(const PathRequest& path, const std::vector<PathSpeedResult>& results);

/// Writes run.yaml and report.html into the run's folder.
void write_path_run(const ServoRequest& request, const PathRequest& path, const PathRun& run);

}  // namespace planar
