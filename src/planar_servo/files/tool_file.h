#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/calibration/tool_offsets.h"

namespace planar {

/// Text of tool.yaml; lengths and covariance in mm.
std::string tool_text(const ToolOffsets& tool, const std::string& program,
                      const std::vector<std::filesystem::path>& inputs);

/// Throws InputError naming every fault.
ToolOffsets read_tool(const std::filesystem::path& path);

}  // namespace planar
