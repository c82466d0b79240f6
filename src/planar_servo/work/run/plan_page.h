#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/loop/servo/path/path.h"
#include "planar_servo/work/run/dry_run.h"

namespace planar {

// Pages of what would be done, for whoever checks it before anything moves: the ways in the
// workspace, and by themselves.

/// `remarks` say what was assumed of the path's file, or left out.
std::string plan_page(const Workspace& workspace, const std::filesystem::path& file,
                      const Path& path, const std::vector<std::string>& remarks);

/// `rows` are the first moves to these targets.
std::string plan_page(const Workspace& workspace, const std::filesystem::path& file,
                      const std::vector<TargetRow>& targets, const std::vector<DryRunRow>& rows,
                      const std::vector<std::string>& remarks);

}  // namespace planar
