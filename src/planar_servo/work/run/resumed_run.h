#pragma once

#include <filesystem>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/work/run/servo_run.h"

namespace planar {

/// Returns the table to which a request's run adds its results.
std::filesystem::path results_file(const ServoRequest& request);

/// Returns the files that a run is made with.
std::vector<Origin> run_origins(const ServoRequest& request);

/// Returns these and the servo's settings as comment lines of the table of results.
std::vector<std::string> run_remarks(const ServoRequest& request);

/// Returns the run's folder, which exists then. Throws InputError when there is no run to continue,
/// and when the folder holds that of a path.
const std::filesystem::path& folder_for(const ServoRequest& request);

/// Returns the results that the folder holds. Throws InputError when it holds some although no run
/// is to be continued, and when they were made with other files or settings.
std::vector<TargetResult> results_so_far(const ServoRequest& request);

/// Throws InputError when the target `id` has a result already, but of another place or direction
/// than its `goal`.
void require_same_goal(const std::string& id, const TipPose& goal,
                       const std::vector<TargetResult>& results);

}  // namespace planar
