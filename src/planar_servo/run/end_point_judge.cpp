#include "planar_servo/run/end_point_judge.h"

#include <memory>

#include "planar_servo/files/tool_file.h"
#include "planar_servo/judge/cell_judge.h"

namespace planar {

EndPointJudge judge_by_tracker(const CellSettings& cell, CellDevices& devices,
                               const std::filesystem::path& readings,
                               const std::function<bool()>& stop) {
  const ToolOffsets tool = read_tool(cell.tool);
  if (judge_of(cell, tool) == JudgeKind::kTruth) return {};
  std::shared_ptr<Judge> judge;
  return [=, &devices](const std::string& id, const ServoStep& look) mutable {
    if (!look.measurement.ok())
      return JudgedTip{std::nullopt, 0.0, "the camera does not see the tool's direction"};
    if (!judge) judge = make_judge(JudgeKind::kTracker, cell, tool, devices, readings, stop);
    return judge->judge(id, look.measurement.tip);
  };
}

}  // namespace planar
