#include "planar_servo/files/tables/target_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/error.h"
#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr char kKind[] = "targets";
constexpr int kMillimetreDecimals = 6;
constexpr int kAngleDecimals = 6;

const std::vector<std::string>& needed_columns() {
  static const std::vector<std::string> columns{"id", "x_mm", "y_mm"};
  return columns;
}

TargetRow target_at(CsvTable& table) {
  TargetRow target{std::string(table.text("id")),
                   Eigen::Vector2d(table.number("x_mm"), table.number("y_mm")) * kMillimetre,
                   std::nullopt};
  if (const auto phi_deg = table.optional_number("phi_deg")) target.phi_d = *phi_deg * kDegree;
  return target;
}

bool has_number(const std::vector<std::string_view>& fields) {
  return std::any_of(fields.begin(), fields.end(),
                     [](std::string_view field) { return finite_number(field).has_value(); });
}

}  // namespace

std::vector<TargetRow> read_targets(const std::filesystem::path& path) {
  CsvFile table(path, kKind, needed_columns());
  std::vector<TargetRow> rows;
  std::set<std::string> ids;
  while (table.next_row()) {
    rows.push_back(target_at(table));
    table.require_id_not_in(ids);
    ids.insert(rows.back().id);
  }
  table.throw_if_faulty_or_empty();
  return rows;
}

std::string targets_header() {
  return CsvWriter(kKind, {"id", "x_mm", "y_mm", "phi_deg"}).text();
}

std::string target_line(const TargetRow& row) {
  const std::string phi = row.phi_d ? fixed(*row.phi_d / kDegree, kAngleDecimals) : "";
  return fmt::format("{},{},{}\n", row.id, fixed(row.p_d / kMillimetre, kMillimetreDecimals, ","),
                     phi);
}

TargetLines::TargetLines(const std::string& source, std::set<std::string> taken)
    : table_(source, kKind, needed_columns()), taken_(std::move(taken)) {}

std::optional<TargetRow> TargetLines::next(const std::string& line) {
  ++line_;
  std::string row = line;
  const std::vector<std::string_view> fields = split_fields(line);
  if (!has_columns() && has_number(fields) && fields.front()[0] != '#') {
    table_.take_line("id,x_mm,y_mm,phi_deg", line_);
    fourth_is_optional_ = true;
  }
  if (fourth_is_optional_ && fields.size() == needed_columns().size()) row += ',';
  const bool is_row = table_.take_line(row, line_);
  table_.throw_if_faulty();
  if (!is_row) return std::nullopt;
  TargetRow target = target_at(table_);
  table_.require_id_not_in(taken_);
  table_.throw_if_faulty();
  taken_.insert(target.id);
  return target;
}

}  // namespace planar
