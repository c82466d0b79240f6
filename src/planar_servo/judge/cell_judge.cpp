#include "planar_servo/judge/cell_judge.h"

#include <fmt/format.h>

#include <utility>

#include "planar_servo/core/error.h"
#include "planar_servo/judge/tracker_judge.h"

namespace planar {
namespace {

/// Judges by what a virtual cell knows of itself.
class TruthJudge final : public Judge {
 public:
  explicit TruthJudge(std::function<TipPose()> true_tip) : true_tip_(std::move(true_tip)) {}

  JudgedTip judge(const std::string& /*id*/, const TipPose& /*supposed*/) override {
    const TipPose tip = true_tip_();
    return {tip.p, 0.0, "", tip.phi};
  }
  double common_sigma() const override { return 0.0; }

 private:
  std::function<TipPose()> true_tip_;
};

}  // namespace

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

std::unique_ptr<Judge> make_judge(JudgeKind kind, const CellSettings& cell, const ToolOffsets& tool,
                                  CellDevices& devices, const std::filesystem::path& readings,
                                  const std::function<bool()>& stop) {
  if (kind == JudgeKind::kTruth) return std::make_unique<TruthJudge>(devices.true_tip());
  auto judge = std::make_unique<TrackerJudge>(cell, tool, devices.tracker(), readings, stop);
  judge->make_ready();
  return judge;
}

}  // namespace planar
