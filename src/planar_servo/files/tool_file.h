#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/tool/tool_offsets.h"

namespace planar {

/// Returns the text of tool.yaml, with lengths in mm and the covariance in mm^2.
std::string tool_text(const ToolOffsets& tool, const std::string& program,
                      const std::vector<Origin>& origins);

/// Reads tool.yaml. Throws InputError naming every fault.
ToolOffsets read_tool(const std::filesystem::path& path);

}  // namespace planar
