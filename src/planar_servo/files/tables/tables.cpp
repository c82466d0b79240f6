#include "planar_servo/files/tables/tables.h"

#include <fmt/format.h>

#include <set>

#include "planar_servo/core/units.h"
#include "planar_servo/files/tables/recording.h"
#include "planar_servo/io/csv_table.h"

namespace planar {
namespace {

constexpr int kMicrometreDecimals = 6;  // of a millimetre: a nanometre
constexpr int kAngleDecimals = 6;       // of a degree

Eigen::Vector2d point_mm(CsvTable& table, const char* x, const char* y) {
  return Eigen::Vector2d(table.number(x), table.number(y)) * kMillimetre;
}

std::optional<double> scaled(std::optional<double> value, double unit) {
  return value ? std::optional<double>(*value * unit) : std::nullopt;
}

void add_optional(CsvWriter& writer, std::optional<double> value, double unit, int decimals) {
  if (value)
    writer.add(*value / unit, decimals);
  else
    writer.add_empty();
}

std::variant<std::monostate, TipPose, Joints> plan_place(CsvTable& table, double tool_orientation) {
  const auto given = [&](const char* column) { return !table.text(column).empty(); };
  if (given("x_mm") || given("y_mm")) {
    if (given("theta1_deg")) table.add_fault("has both x_mm and theta1_deg; give one of them");
    return TipPose{point_mm(table, "x_mm", "y_mm"),
                   scaled(table.optional_number("phi_deg"), kDegree).value_or(tool_orientation)};
  }
  if (given("theta1_deg"))
    return Joints(
        Joints(table.number("theta1_deg"), table.number("theta2_deg"), table.number("theta3_deg")) *
        kDegree);
  return std::monostate();
}

}  // namespace

void read_pairs(const std::filesystem::path& path,
                const std::function<void(const PairRow&)>& take) {
  CsvFile table(path, "pairs",
                {"id", "x_vision_mm", "y_vision_mm", "x_tracker_mm", "y_tracker_mm"});
  PairRow row;
  while (table.next_row()) {
    row.id = table.text("id");
    row.p_vision = point_mm(table, "x_vision_mm", "y_vision_mm");
    row.p_tracker = point_mm(table, "x_tracker_mm", "y_tracker_mm");
    row.phi = scaled(table.optional_number("phi_deg"), kDegree);
    row.sigma_vision = scaled(table.optional_number("sigma_vision_mm"), kMillimetre);
    row.sigma_tracker = scaled(table.optional_number("sigma_tracker_mm"), kMillimetre);
    row.plan = table.text("plan");
    take(row);
  }
  table.throw_if_faulty_or_empty();
}

std::vector<PairRow> read_pairs(const std::filesystem::path& path) {
  std::vector<PairRow> rows;
  read_pairs(path, [&](const PairRow& row) { rows.push_back(row); });
  return rows;
}

std::string pairs_text(const std::vector<PairRow>& rows) {
  CsvWriter writer("pairs", {"id", "x_vision_mm", "y_vision_mm", "x_tracker_mm", "y_tracker_mm",
                             "phi_deg", "sigma_vision_mm", "sigma_tracker_mm", "plan"});
  for (const PairRow& row : rows) {
    writer.add(row.id);
    for (const double value :
         {row.p_vision.x(), row.p_vision.y(), row.p_tracker.x(), row.p_tracker.y()})
      writer.add(value / kMillimetre, kMicrometreDecimals);
    add_optional(writer, row.phi, kDegree, kAngleDecimals);
    add_optional(writer, row.sigma_vision, kMillimetre, kMicrometreDecimals);
    add_optional(writer, row.sigma_tracker, kMillimetre, kMicrometreDecimals);
    writer.add(row.plan).end_row();
  }
  return writer.text();
}

std::vector<PlanRow> read_plan(const std::filesystem::path& path, double tool_orientation) {
  CsvFile table(path, "plan", {"id", "plan"});
  std::vector<PlanRow> rows;
  std::set<std::string> ids;
  while (table.next_row()) {
    PlanRow row{std::string(table.text("id")), std::string(table.text("plan")),
                plan_place(table, tool_orientation)};
    table.require_id_not_in(ids);
    ids.insert(row.id);
    if (row.id.find('/') != std::string::npos)
      table.add_fault(fmt::format("id is '{}'; it names images, so '/' is not allowed", row.id));
    check_plan(table, row.plan);
    if (!shows_board(row.plan) && std::holds_alternative<std::monostate>(row.where))
      table.add_fault("has no position; x_mm, y_mm or theta1_deg ... theta3_deg are needed");
    rows.push_back(std::move(row));
  }
  table.throw_if_faulty_or_empty();
  return rows;
}

std::string plan_text(const std::vector<PlanRow>& rows) {
  CsvWriter writer(
      "plan", {"id", "plan", "x_mm", "y_mm", "phi_deg", "theta1_deg", "theta2_deg", "theta3_deg"});
  for (const PlanRow& row : rows) {
    writer.add(row.id).add(row.plan);
    if (const auto* tip = std::get_if<TipPose>(&row.where)) {
      writer.add(tip->p.x() / kMillimetre, kMicrometreDecimals);
      writer.add(tip->p.y() / kMillimetre, kMicrometreDecimals);
      writer.add(tip->phi / kDegree, kAngleDecimals);
    } else {
      writer.add_empty().add_empty().add_empty();
    }
    const auto* joints = std::get_if<Joints>(&row.where);
    for (int j = 0; j < 3; ++j)
      add_optional(writer, joints ? std::optional<double>((*joints)[j]) : std::nullopt, kDegree,
                   kAngleDecimals);
    writer.end_row();
  }
  return writer.text();
}

}  // namespace planar
