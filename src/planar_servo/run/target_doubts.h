#pragma once

#include <filesystem>
#include <vector>

#include "planar_servo/arm/workspace.h"
#include "planar_servo/core/error.h"
#include "planar_servo/tables/target_table.h"

namespace planar {

/// Returns what can hardly be meant in a table of targets: places written in metres, which are all
/// within a millimetre of the base's axes, and directions in radians.
std::vector<Refusal> target_doubts(const std::vector<TargetRow>& targets,
                                   const Workspace& workspace);

/// Logs these doubts. Throws InputError for places in metres if none of them lies in the workspace.
/// `file` names the table.
void question_targets(const std::vector<TargetRow>& targets, const Workspace& workspace,
                      const std::filesystem::path& file);

}  // namespace planar
