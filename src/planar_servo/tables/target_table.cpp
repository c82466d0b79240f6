#include "planar_servo/tables/target_table.h"

#include <algorithm>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

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
      UnendedRow::kRefused};
  return targets;
}

bool has_number(const std::vector<std::string_view>& fields) {
  return std::any_of(fields.begin(), fields.end(),
                     [](std::string_view field) { return finite_number(field).has_value(); });
}

}  // namespace

std::vector<TargetRow> read_targets(const std::filesystem::path& path) {
  TableFile<TargetRow> table(path, target_schema());
  try {
    return table.rows(RowIds::kOwn);
  } catch (const InputError&) {
    // Its board views and sweeps need no place.
    if (!table.has_column("plan")) throw;
    throw InputError(
        {"is a plan for planar-record, by its column plan, and not every row has a "
         "place to go to",
         "a table of targets is needed, with the columns id, x_mm, y_mm and perhaps "
         "phi_deg",
         path});
  }
}

std::string targets_header() {
  return target_schema().header();
}

std::string target_line(const TargetRow& row) {
  return target_schema().line(row);
}

TargetLines::TargetLines(const std::string& source, std::set<std::string> taken)
    : table_(source, target_schema().kind, target_schema().columns().required(), {},
             target_schema().columns().optional()),
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
  ColumnReader columns(table_);
  target_schema().list_columns(columns, target);
  table_.require_id_not_in(taken_);
  table_.throw_if_faulty();
  taken_.insert(target.id);
  return target;
}

}  // namespace planar
