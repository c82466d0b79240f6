#include "planar_servo/run/dry_run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

std::string refusal_text(const DryRunRow& row) {
  return fmt::format("{}: refused: {}\n", row.id, *row.plan.refusal);
}

}  // namespace

std::vector<DryRunRow> plan_first_moves(const CellSettings& cell,
                                        const std::vector<TargetRow>& targets) {
  DryRun dry(cell);
  std::vector<DryRunRow> rows;
  rows.reserve(targets.size());
  for (const TargetRow& target : targets) rows.push_back(dry.plan(target));
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

nlohmann::ordered_json plan_answer(const DryRunRow& row) {
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
  for (const DryRunRow& row : rows) moves.push_back(nlohmann::json(plan_answer(row)));
  return {{"moves", moves}};
}

}  // namespace planar
