#include "planar_servo/run/dry_run.h"

#include "planar_servo/files/arm_file.h"
#include "planar_servo/servo/approach.h"

namespace planar {

TipPose target_pose(const TargetRow& target, double tool_orientation) {
  return {target.p_d, target.phi_d.value_or(tool_orientation)};
}

DryRun::DryRun(const CellSettings& cell)
    : tool_orientation_(cell.tool_orientation),
      planner_(servo_planner(cell)),
      servo_(cell.servo),
      near_(cell.arm.home) {}

DryRunRow DryRun::plan(const TargetRow& target) {
  DryRunRow row{target.id, planner_.plan(target_pose(target, tool_orientation_), near_),
                Pulses::Zero()};
  if (!row.plan.refusal)
    row.plan.refusal = approach_refusal(planner_, servo_, near_, row.plan.theta);
  if (row.plan.refusal) return row;
  near_ = row.plan.theta;
  row.pulses = planner_.transmission().pulses_from_joints(near_);
  return row;
}

void refuse_outside_map(std::vector<DryRunRow>& rows, const std::vector<TargetRow>& targets,
                        double tool_orientation, const VisionCalibration& vision) {
  if (!vision.error_map) return;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TipPose target = target_pose(targets[i], tool_orientation);
    if (rows[i].plan.refusal || predict_error_at(vision, target).inside) continue;
    rows[i].plan.refusal =
        "the error map is not valid here: record training positions around this target";
  }
}

}  // namespace planar
