#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/devices/judge.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/tool/tool_offsets.h"

namespace planar {

/// Returns who judges this cell: its truth if it is virtual, or else its tracker. Throws InputError
/// with a remedy when it has neither, or when its tracker cannot be tied to the end point.
JudgeKind judge_of(const CellSettings& cell, const ToolOffsets& tool);

/// Returns the judge, ready to be asked. A tracker's readings also go to the table `readings`,
/// which grows; its monuments are read first, see TrackerJudge::make_ready().
std::shared_ptr<Judge> make_judge(JudgeKind kind, const CellSettings& cell, const ToolOffsets& tool,
                                  CellDevices& devices, const std::filesystem::path& readings,
                                  const std::function<bool()>& stop);

}  // namespace planar
