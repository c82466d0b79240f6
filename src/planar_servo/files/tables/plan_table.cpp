#include "planar_servo/files/tables/plan_table.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <set>

#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

using OptionalJoints = std::array<std::optional<double>, 3>;

void take_joints(Columns& columns, const OptionalJoints& theta, PlanRow& row) {
  Joints joints(0.0, 0.0, 0.0);
  for (int j = 0; j < 3; ++j) {
    joints[j] = theta[j].value_or(0.0);
    columns.check(theta[j].has_value(),
                  fmt::format("theta{}_deg is ''; a finite number is needed", j + 1));
  }
  row.where = joints;
}

/// Lists the columns of a position. A pose whose file names no phi takes `tool_orientation`.
void list_place(Columns& columns, PlanRow& row, double tool_orientation) {
  std::optional<Eigen::Vector2d> p;
  std::optional<double> phi;
  OptionalJoints theta;
  if (const auto* tip = std::get_if<TipPose>(&row.where)) {
    p = tip->p;
    phi = tip->phi;
  }
  if (const auto* joints = std::get_if<Joints>(&row.where))
    for (int j = 0; j < 3; ++j) theta[j] = (*joints)[j];
  columns.optional_point("x_mm", "y_mm", p, kMillimetre, 6, Column::kOptional);
  columns.optional_number("phi_deg", phi, kDegree, 6, Column::kOptional);
  for (int j = 0; j < 3; ++j)
    columns.optional_number(fmt::format("theta{}_deg", j + 1), theta[j], kDegree, 6,
                            Column::kOptional);
  if (!columns.reading()) return;
  row.where = std::monostate();
  if (p) row.where = TipPose{*p, phi.value_or(tool_orientation)};
  columns.check(!p || !theta[0], "has both x_mm and theta1_deg; give one of them");
  if (!p && theta[0]) take_joints(columns, theta, row);
}

TableSchema<PlanRow> schema(double tool_orientation) {
  return {
      "plan", [=](Columns& columns, PlanRow& row) {
        columns.text("id", row.id);
        columns.check(row.id.find('/') == std::string::npos,
                      fmt::format("id is '{}'; it names images, so '/' is not allowed", row.id));
        columns.choice("plan", row.plan, kPlans);
        list_place(columns, row, tool_orientation);
        columns.check(shows_board(row.plan) || !std::holds_alternative<std::monostate>(row.where),
                      "has no position; x_mm, y_mm or theta1_deg ... theta3_deg are needed");
      }};
}

}  // namespace

std::vector<PlanRow> read_plan(const std::filesystem::path& path, double tool_orientation) {
  const TableSchema<PlanRow> plan = schema(tool_orientation);
  TableFile<PlanRow> table(path, plan);
  std::vector<PlanRow> rows;
  std::set<std::string> ids;
  for (PlanRow row; table.next(row);) {
    table.require_id_not_in(ids);
    ids.insert(row.id);
    rows.push_back(row);
  }
  table.throw_if_faulty_or_empty();
  return rows;
}

std::string plan_text(const std::vector<PlanRow>& rows) {
  const TableSchema<PlanRow> plan = schema(0.0);
  std::string text = plan.header();
  for (const PlanRow& row : rows) text += plan.line(row);
  return text;
}

}  // namespace planar
