#include "planar_servo/judge/cell_judge.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/judge/tracker_judge.h"

namespace planar {
JudgeKind judge_of(const CellSettings& cell, const ToolOffsets& tool) {
  if (cell.truth) return JudgeKind::kTruth;
  require_judging_tracker(cell);
  if (!tool.reflector_known)
    throw InputError(fmt::format(
        "{}: does not say where the reflector sits on the tool, so the tracker cannot judge the "
        "end point; calibrate with the tracker (planar-record, planar-pair-tracker)",
        cell.tool.string()));
  return JudgeKind::kTracker;
}

std::shared_ptr<Judge> make_judge(JudgeKind kind, const CellSettings& cell, const ToolOffsets& tool,
                                  CellDevices& devices, const std::filesystem::path& readings,
                                  const std::function<bool()>& stop) {
  if (kind == JudgeKind::kTruth) return devices.truth();
  auto judge = std::make_shared<TrackerJudge>(cell, tool, devices.tracker(), readings, stop);
  judge->make_ready();
  return judge;
}

}  // namespace planar
