#include "planar_servo/files/tables/target_table.h"

#include <algorithm>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/tables/table_columns.h"

namespace planar {
namespace {

const TableSchema<TargetRow>& target_schema() {
  static const TableSchema<TargetRow> targets{
      "targets",
      [](Columns& columns, TargetRow& row) {
        columns.text("id", row.id);
        columns.point("x_mm", "y_mm", row.p_d, kMillimetre, 6);
        columns.optional_number("phi_deg", row.phi_d, kDegree, 6, Column::kOptional);
      },
      UnendedRow::kRefused, RowIds::kOwn};
  return targets;
}

bool has_number(const std::vector<std::string_view>& fields) {
  return std::any_of(fields.begin(), fields.end(),
                     [](std::string_view field) { return finite_number(field).has_value(); });
}

/// Returns true for a plan of which a row has no place, as board views and sweeps have none.
bool is_plan_without_places(const std::filesystem::path& path) {
  try {
    CsvFile table(path, target_schema().kind, {"plan"}, {}, UnendedRow::kRefused, {"x_mm", "y_mm"});
    while (table.next_row())
      if (table.text("x_mm").empty() || table.text("y_mm").empty()) return true;
  } catch (const InputError&) {
    // it has no column plan, or a place by another name
  }
  return false;
}

}  // namespace

std::vector<TargetRow> read_targets(const std::filesystem::path& path) {
  try {
    return TableFile<TargetRow>(path, target_schema()).rows();
  } catch (const InputError&) {
    if (!is_plan_without_places(path)) throw;
  }
  throw InputError(
      {"is a plan for planar-record, by its column plan, and not every row has a place to go to",
       "a table of targets is needed, with the columns id, x_mm, y_mm and perhaps phi_deg", path});
}

std::string targets_header() {
  return target_schema().header();
}

std::string target_line(const TargetRow& row) {
  return target_schema().line(row);
}

TargetLines::TargetLines(const std::string& source, std::set<std::string> taken)
    : table_(source, target_schema().kind, target_schema().columns().names(Column::kRequired), {},
             target_schema().columns().names(Column::kOptional)),
      taken_(std::move(taken)) {}

std::optional<TargetRow> TargetLines::next(const std::string& line, bool has_end) {
  ++line_;
  std::string row = line;
  const std::vector<std::string_view> fields = split_fields(line);
  if (!has_columns() && has_number(fields) && !is_comment(line)) {
    table_.take_line("id,x_mm,y_mm,phi_deg", line_);
    fourth_is_optional_ = true;
  }
  if (fourth_is_optional_ && fields.size() == 3) row += ',';
  const bool is_row = table_.take_line(row, line_);
  if (is_row && !has_end) table_.refuse_torn_row();
  table_.throw_if_faulty();
  if (!is_row) return std::nullopt;
  TargetRow target;
  Columns columns(table_);
  target_schema().list_columns(columns, target);
  table_.require_id_not_in(taken_);
  table_.throw_if_faulty();
  taken_.insert(target.id);
  return target;
}

TableForm target_form() {
  return form_of(target_schema());
}

}  // namespace planar
