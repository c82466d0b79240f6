#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/core/names.h"
#include "planar_servo/judge/judge.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/tool/tool_offsets.h"

namespace planar {

/// Who judges a cell.
enum class JudgeKind { kTruth, kTracker };

constexpr Named<JudgeKind> kJudgeKinds[] = {{JudgeKind::kTruth, "truth"},
                                            {JudgeKind::kTracker, "tracker"}};

/// Returns who judges this cell: its truth if it is virtual, or else its tracker. Throws InputError
/// with a remedy when it has neither, or when its tracker cannot be tied to the end point.
JudgeKind judge_of(const CellSettings& cell, const ToolOffsets& tool);

/// Returns the judge, ready to be asked. A tracker's readings also go to the table `readings`,
/// which grows; its monuments are read first, see TrackerJudge::make_ready().
std::unique_ptr<Judge> make_judge(JudgeKind kind, const CellSettings& cell, const ToolOffsets& tool,
                                  CellDevices& devices, const std::filesystem::path& readings,
                                  const std::function<bool()>& stop);

}  // namespace planar
