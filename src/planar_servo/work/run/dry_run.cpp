#include "planar_servo/work/run/dry_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/loop/servo/motion_guard.h"

namespace planar {
namespace {

std::string refusal_text(const DryRunRow& row) {
  return fmt::format("{}: refused: {}\n", row.id, *row.plan.refusal);
}

}  // namespace

TipPose target_pose(const TargetRow& target, double tool_orientation) {
  return {target.p_d, target.phi_d.value_or(tool_orientation)};
}

DryRun::DryRun(const CellSettings& cell, const Joints& start)
    : tool_orientation_(cell.tool_orientation),
      planner_(servo_planner(cell)),
      servo_(cell.servo),
      near_(start) {}

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

std::vector<DryRunRow> first_moves_to(const CellSettings& cell, const Joints& start,
                                      const std::vector<TargetRow>& targets) {
  DryRun dry(cell, start);
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

namespace {

/// Coordinates up to this are those of an arm of a metre, written in metres.
constexpr double kNearAxes_m = 1.0 * kMillimetre;
/// A full turn in radians is a little less.
constexpr double kRadiansOfTurn = 6.3;

bool is_whole(double number) {
  constexpr double kWrittenDigit = 1e-6;
  return std::abs(number - std::round(number)) < kWrittenDigit;
}

std::optional<Refusal> doubt_of_places(const std::vector<TargetRow>& targets,
                                       const Workspace& workspace) {
  double farthest_m = 0.0;
  for (const TargetRow& target : targets)
    farthest_m = std::max(farthest_m, target.p_d.cwiseAbs().maxCoeff());
  if (targets.empty() || farthest_m >= kNearAxes_m || workspace.radius_max_m <= kNearAxes_m)
    return std::nullopt;
  return Refusal{fmt::format("no coordinate is larger than {:g} mm, while the workspace reaches to "
                             "{:g} mm; metres would be such numbers",
                             mm(farthest_m), mm(workspace.radius_max_m)),
                 "write millimetres, such as 200 for 0.2 m"};
}

std::optional<Refusal> doubt_of_directions(const std::vector<TargetRow>& targets) {
  double largest = 0.0;
  bool any_broken = false;
  for (const TargetRow& target : targets) {
    const double number = target.phi_d.value_or(0.0) / kDegree;
    if (std::abs(number) >= kRadiansOfTurn) return std::nullopt;
    largest = std::max(largest, std::abs(number));
    any_broken = any_broken || !is_whole(number);
  }
  if (!any_broken) return std::nullopt;
  return Refusal{fmt::format("phi_deg is at most {:g} in every row; radians would be such numbers, "
                             "while degrees are read",
                             largest),
                 "write degrees, such as 90 for 1.571 radians, or leave it if it is meant so"};
}

}  // namespace

std::vector<Refusal> target_doubts(const std::vector<TargetRow>& targets,
                                   const Workspace& workspace) {
  std::vector<Refusal> doubts;
  for (const auto& doubt : {doubt_of_places(targets, workspace), doubt_of_directions(targets)})
    if (doubt) doubts.push_back(*doubt);
  return doubts;
}

void question_targets(const std::vector<TargetRow>& targets, const Workspace& workspace,
                      const std::filesystem::path& file) {
  const bool any_allowed =
      std::any_of(targets.begin(), targets.end(),
                  [&](const TargetRow& target) { return !workspace.violation(target.p_d); });
  const auto places = doubt_of_places(targets, workspace);
  if (places && !any_allowed) throw InputError(places->at(file));
  for (const Refusal& doubt : target_doubts(targets, workspace))
    spdlog::warn(doubt.at(file).text());
}

}  // namespace planar
