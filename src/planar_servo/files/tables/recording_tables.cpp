#include "planar_servo/files/tables/recording_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/tables/table_columns.h"

namespace planar {
namespace {

constexpr std::array<const char*, 3> kJointColumns{"theta1_deg", "theta2_deg", "theta3_deg"};

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
  columns.optional_point("x_mm", "y_mm", p, kMillimetre, 6);
  columns.optional_number("phi_deg", phi, kDegree, 6);
  list_joints(columns, theta);
  if (!columns.reading()) return;
  row.where = std::monostate();
  if (theta) row.where = *theta;
  if (p) row.where = TipPose{*p, phi.value_or(tool_orientation)};
  columns.check(!p || !theta,
                {"has both x_mm and theta1_deg", "give one of them", "", Cause::kContradiction});
}

TableSchema<PlanRow> plan_schema(double tool_orientation) {
  return {
      "plan",
      [=](Columns& columns, PlanRow& row) {
        columns.text("id", row.id);
        columns.check(row.id.find('/') == std::string::npos,
                      {fmt::format("id is '{}'", row.id), "it names images, so '/' is not allowed"},
                      "id");
        columns.choice("plan", row.plan, kPurposes);
        list_place(columns, row, tool_orientation);
        columns.check(shows_board(row.plan) || !std::holds_alternative<std::monostate>(row.where),
                      {"has no position", "x_mm, y_mm or theta1_deg ... theta3_deg are needed", "",
                       Cause::kMissing});
      },
      UnendedRow::kRefused, RowIds::kOwn};
}

const TableSchema<FrameRow>& frame_schema() {
  static const TableSchema<FrameRow> frames{
      "frames", [](Columns& columns, FrameRow& row) {
        columns.text("id", row.id);
        columns.text("image", row.image);
        columns.number("t_s", row.t_s, 1.0, 6);
        columns.choice("plan", row.plan, kPurposes);
        list_joints(columns, row.theta);
        list_pulses(columns, row.pulses);
        columns.whole_number("region_u0_px", row.region_px.x);
        columns.whole_number("region_v0_px", row.region_px.y);
        columns.whole_number("region_width_px", row.region_px.width);
        columns.whole_number("region_height_px", row.region_px.height);
      }};
  return frames;
}

}  // namespace

std::vector<PlanRow> read_plan(const std::filesystem::path& path, double tool_orientation) {
  const TableSchema<PlanRow> plan = plan_schema(tool_orientation);
  return TableFile<PlanRow>(path, plan).rows();
}

std::string plan_text(const std::vector<PlanRow>& rows) {
  return plan_schema(0.0).text(rows);
}

std::vector<FrameRow> read_frames(const std::filesystem::path& recording) {
  if (!std::filesystem::is_directory(recording))
    throw InputError({"is not a folder", "a recording made by planar-record is needed", recording,
                      Cause::kMissing});
  if (!std::filesystem::exists(recording / "frames.csv"))
    throw InputError(
        {"holds no frames.csv",
         "a recording made by planar-record is needed (pictures are named one by one: FOLDER/*)",
         recording, Cause::kMissing});
  return TableFile<FrameRow>(recording / "frames.csv", frame_schema())
      .rows("record some with planar-record");
}

std::string frames_header() {
  return frame_schema().header();
}

std::string frame_line(const FrameRow& row) {
  return frame_schema().line(row);
}

void list_joints(Columns& columns, Joints& theta) {
  for (std::size_t j = 0; j < kJointColumns.size(); ++j)
    columns.number(kJointColumns[j], theta[static_cast<Eigen::Index>(j)], kDegree, 9);
}

void list_joints(Columns& columns, std::optional<Joints>& theta) {
  std::array<std::optional<double>, 3> angles;
  for (std::size_t j = 0; j < angles.size(); ++j) {
    if (theta) angles[j] = (*theta)[static_cast<Eigen::Index>(j)];
    columns.optional_number(kJointColumns[j], angles[j], kDegree, 6);
  }
  if (!columns.reading()) return;
  theta.reset();
  const auto is_given = [](const std::optional<double>& angle) { return angle.has_value(); };
  if (std::none_of(angles.begin(), angles.end(), is_given)) return;
  for (std::size_t j = 0; j < angles.size(); ++j)
    columns.check(is_given(angles[j]),
                  {fmt::format("{} is ''", kJointColumns[j]), "a finite number is needed"},
                  kJointColumns[j]);
  theta = Joints(angles[0].value_or(0.0), angles[1].value_or(0.0), angles[2].value_or(0.0));
}

void list_pulses(Columns& columns, Pulses& pulses) {
  columns.whole_number("m1_pulses", pulses[0]);
  columns.whole_number("m2_pulses", pulses[1]);
  columns.whole_number("m3_pulses", pulses[2]);
}

std::vector<TableForm> recording_forms() {
  return {form_of(plan_schema(0.0)), form_of(frame_schema())};
}

}  // namespace planar
