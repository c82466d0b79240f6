#include "planar_servo/run/dry_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "planar_servo/core/text.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/servo/approach.h"

namespace planar {
namespace {

std::string refusal_text(const DryRunRow& row) {
  return fmt::format("{}: refused: {}\n", row.id, *row.plan.refusal);
}

}  // namespace

TipPose target_pose(const TargetRow& target, double tool_orientation) {
  return {target.p_d, target.phi_d.value_or(tool_orientation)};
}

DryRun::DryRun(const CellSettings& cell)
    : tool_orientation_(cell.tool_orientation),
      planner_(servo_planner(cell)),
      servo_(cell.servo),
      near_(cell.arm.home) {}

DryRunRow DryRun::first_move(const TargetRow& target) {
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

std::vector<DryRunRow> first_moves_to(const CellSettings& cell,
                                      const std::vector<TargetRow>& targets) {
  DryRun dry(cell);
  std::vector<DryRunRow> rows;
  rows.reserve(targets.size());
  for (const TargetRow& target : targets) rows.push_back(dry.first_move(target));
  return rows;
}

std::size_t count_refused(const std::vector<DryRunRow>& rows) {
  return static_cast<std::size_t>(std::count_if(
      rows.begin(), rows.end(), [](const DryRunRow& row) { return row.plan.refusal.has_value(); }));
}

std::string dry_run_text(const std::vector<DryRunRow>& rows) {
  std::string text;
  for (const DryRunRow& row : rows)
    text += row.plan.refusal ? refusal_text(row)
                             : fmt::format("{}: joints {} deg, pulses {} {} {}\n", row.id,
                                           fixed(row.plan.theta / kDegree, 4, " "), row.pulses[0],
                                           row.pulses[1], row.pulses[2]);
  return text;
}

std::string refusals_text(const std::vector<DryRunRow>& rows) {
  std::string text;
  for (const DryRunRow& row : rows)
    if (row.plan.refusal) text += refusal_text(row);
  return text;
}

nlohmann::ordered_json first_move_answer(const DryRunRow& row) {
  if (row.plan.refusal)
    return {{"target", row.id}, {"status", "refused"}, {"reason", *row.plan.refusal}};
  const Eigen::Vector3d deg = row.plan.theta / kDegree;
  return {{"target", row.id},
          {"status", "planned"},
          {"theta_deg", {deg[0], deg[1], deg[2]}},
          {"pulses", {row.pulses[0], row.pulses[1], row.pulses[2]}}};
}

nlohmann::json dry_run_json(const std::vector<DryRunRow>& rows) {
  nlohmann::json moves = nlohmann::json::array();
  for (const DryRunRow& row : rows) moves.push_back(nlohmann::json(first_move_answer(row)));
  return {{"moves", moves}};
}

}  // namespace planar
