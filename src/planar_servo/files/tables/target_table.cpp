#include "planar_servo/files/tables/target_table.h"

#include <algorithm>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/table_columns.h"

namespace planar {
namespace {

const TableSchema<TargetRow>& target_schema() {
  static const TableSchema<TargetRow> targets{
      "targets",
      [](Columns& columns, TargetRow& row) {
        columns.text("id", row.id);
        columns.point("x_mm", "y_mm", row.p_d, kMillimetre, 6);
        columns.optional_number("phi_deg", row.phi_d, kDegree, 6);
        if (columns.reading() || !row.tool.empty())
          columns.text("tool", row.tool, Column::kOptional);
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

struct PathRow {
  Eigen::Vector2d p{0.0, 0.0};
  std::optional<Eigen::Vector2d> via{};
  std::optional<double> phi{};
};

const TableSchema<PathRow>& path_schema() {
  static const TableSchema<PathRow> schema{
      "path",
      [](Columns& columns, PathRow& row) {
        columns.point("x_mm", "y_mm", row.p, kMillimetre, 6);
        columns.optional_point("via_x_mm", "via_y_mm", row.via, kMillimetre, 6);
        columns.optional_number("phi_deg", row.phi, kDegree, 6);
      },
      UnendedRow::kRefused};
  return schema;
}

/// Says why a row cannot be reached from the place before it; empty when it can.
std::optional<Refusal> fault_of(const Waypoint& to, const Waypoint& from) {
  if (!to.via && (to.pose.p - from.pose.p).norm() < kSamePoint_m)
    return Refusal{"repeats the place before it", "leave the row out", "", Cause::kExists};
  const auto fault = to.via ? arc_fault(from.pose.p, *to.via, to.pose.p) : std::nullopt;
  if (!fault) return std::nullopt;
  return Refusal{*fault};
}

void list_number(Columns& columns, const std::string& column, const std::optional<double>& value) {
  std::optional<double> field = value;
  columns.optional_number(column, field, kMillimetre, 6, Column::kRequired);
}

/// Lists the columns that only a look which found the tool fills.
void list_seen(Columns& columns, const PathLookRow& row) {
  const TipMeasurement& m = row.look.measurement;
  const auto number = [&](const char* column, double value, double unit) {
    std::optional<double> field;
    if (m.ok()) field = value;
    columns.optional_number(column, field, unit, 6, Column::kRequired);
  };
  number("x_mm", m.tip.p.x(), kMillimetre);
  number("y_mm", m.tip.p.y(), kMillimetre);
  number("phi_deg", m.tip.phi, kDegree);
  number("uncertainty_mm", m.uncertainty_m, kMillimetre);
  number("across_mm", row.look.seen.across_m, kMillimetre);
  number("lag_mm", row.lag_m(), kMillimetre);
}

const TableSchema<PathLookRow>& look_schema() {
  static const TableSchema<PathLookRow> schema{
      "path_looks", [](Columns& columns, PathLookRow& row) {
        PathLook& look = row.look;
        columns.choice("guided_by", row.guidance, kGuidances);
        columns.number("speed_mm_s", row.speed_m_s, kMillimetre, 6);
        columns.number("t_s", look.t_s, 1.0, 6);
        columns.text("status", look.measurement.word);
        columns.number("along_mm", look.along_m, kMillimetre, 6);
        columns.point("x_d_mm", "y_d_mm", look.desired.p, kMillimetre, 6);
        columns.number("phi_d_deg", look.desired.phi, kDegree, 6);
        list_seen(columns, row);
        columns.point("dx_correction_mm", "dy_correction_mm", look.correction, kMillimetre, 6);
        list_joints(columns, look.theta);
        list_number(columns, "across_mm_truth",
                    row.truth ? std::optional(row.truth->across_m) : std::nullopt);
        list_number(columns, "lag_mm_truth", row.lag_truth_m());
      }};
  return schema;
}

void list_errors(Columns& columns, const std::optional<PathErrors>& errors,
                 const std::string& judge) {
  const auto number = [&](const char* name, double value) {
    list_number(columns, name + judge, errors ? std::optional(value) : std::nullopt);
  };
  const PathErrors found = errors.value_or(PathErrors{});
  number("deviation_mean_mm", found.across_m.mean);
  number("deviation_p95_mm", found.across_m.p95);
  number("deviation_max_mm", found.across_m.max);
  number("lag_mean_mm", found.lag_mean_m);
  number("lag_max_mm", found.lag_max_m);
}

const TableSchema<PathSpeedResult>& result_schema_of_paths() {
  static const TableSchema<PathSpeedResult> schema{
      "path_results", [](Columns& columns, PathSpeedResult& result) {
        columns.choice("guided_by", result.guidance, kGuidances);
        columns.number("speed_mm_s", result.speed_m_s, kMillimetre, 6);
        columns.choice("status", result.status, kServoStatuses);
        columns.text("reason", result.reason);
        columns.whole_number("looks", result.looks);
        columns.number("seconds", result.seconds, 1.0, 3);
        list_errors(columns, result.own_view, "_own_view");
        list_errors(columns, result.truth, "_truth");
      }};
  return schema;
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
       "a table of targets is needed, with the columns id, x_mm, y_mm and perhaps phi_deg", path,
       Cause::kForeign});
}

std::string targets_header() {
  return target_schema().header();
}

std::string target_line(const TargetRow& row) {
  return target_schema().line(row);
}

std::string targets_text(const std::vector<TargetRow>& rows) {
  const bool has_tools =
      std::any_of(rows.begin(), rows.end(), [](const TargetRow& row) { return !row.tool.empty(); });
  std::string text = targets_header();
  if (has_tools) text.insert(text.size() - 1, ",tool");
  for (const TargetRow& row : rows) {
    text += target_line(row);
    if (has_tools && row.tool.empty()) text.insert(text.size() - 1, ",");
  }
  return text;
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

Path read_path(const CsvSource& source, double tool_orientation) {
  TableFile<PathRow> table(source, path_schema());
  std::vector<Waypoint> waypoints;
  for (PathRow row; table.next(row);) {
    const Waypoint next{{row.p, row.phi.value_or(tool_orientation)}, row.via};
    if (waypoints.empty() && row.via)
      table.add_fault({"the first row is where the path begins", "its via columns must be empty"});
    if (!waypoints.empty())
      if (const auto fault = fault_of(next, waypoints.back())) table.add_fault(*fault);
    waypoints.push_back(next);
  }
  table.throw_if_faulty_or_empty();
  if (waypoints.size() < 2)
    throw InputError({"a path needs at least two rows: its beginning and its end", "", source.path,
                      Cause::kInsufficient});
  return Path(waypoints);
}

std::optional<double> PathLookRow::lag_truth_m() const {
  if (!truth) return std::nullopt;
  return look.along_now_m - truth->along_m;
}

std::string path_looks_header() {
  return look_schema().header();
}

std::string path_look_line(const PathLookRow& row) {
  return look_schema().line(row);
}

std::string path_results_header(const std::vector<std::string>& remarks) {
  return result_schema_of_paths().header(remarks);
}

std::string path_result_line(const PathSpeedResult& result) {
  return result_schema_of_paths().line(result);
}

std::vector<TableForm> target_forms() {
  return {form_of(target_schema()), form_of(path_schema()), form_of(look_schema()),
          form_of(result_schema_of_paths())};
}

}  // namespace planar
