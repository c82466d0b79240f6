#include "planar_servo/tables/plan_table.h"

#include <fmt/format.h>

#include <optional>

#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"
#include "planar_servo/tables/joint_tables.h"

namespace planar {
namespace {

/// Lists the columns of a position. A pose whose file names no phi takes `tool_orientation`.
void list_place(Columns& columns, PlanRow& row, double tool_orientation) {
  std::optional<Eigen::Vector2d> p;
  std::optional<double> phi;
  std::optional<Joints> theta;
  if (const auto* tip = std::get_if<TipPose>(&row.where)) {
    p = tip->p;
    phi = tip->phi;
  }
  if (const auto* joints = std::get_if<Joints>(&row.where)) theta = *joints;
  columns.optional_point("x_mm", "y_mm", p, kMillimetre, 6, Column::kOptional);
  columns.optional_number("phi_deg", phi, kDegree, 6, Column::kOptional);
  list_joints(columns, theta);
  if (!columns.reading()) return;
  row.where = std::monostate();
  if (theta) row.where = *theta;
  if (p) row.where = TipPose{*p, phi.value_or(tool_orientation)};
  columns.check(!p || !theta, {"has both x_mm and theta1_deg", "give one of them"});
}

TableSchema<PlanRow> schema(double tool_orientation) {
  return {"plan",
          [=](Columns& columns, PlanRow& row) {
            columns.text("id", row.id);
            columns.check(
                row.id.find('/') == std::string::npos,
                {fmt::format("id is '{}'", row.id), "it names images, so '/' is not allowed"});
            columns.choice("plan", row.plan, kPlans);
            list_place(columns, row, tool_orientation);
            columns.check(
                shows_board(row.plan) || !std::holds_alternative<std::monostate>(row.where),
                {"has no position", "x_mm, y_mm or theta1_deg ... theta3_deg are needed"});
          },
          UnendedRow::kRefused};
}

}  // namespace

std::vector<PlanRow> read_plan(const std::filesystem::path& path, double tool_orientation) {
  const TableSchema<PlanRow> plan = schema(tool_orientation);
  return TableFile<PlanRow>(path, plan).rows(RowIds::kOwn);
}

std::string plan_text(const std::vector<PlanRow>& rows) {
  return schema(0.0).text(rows);
}

}  // namespace planar
