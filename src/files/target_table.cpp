#include "files/target_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/units.h"

namespace planar {
namespace {

constexpr char kKind[] = "targets";
constexpr int kMillimetreDecimals = 6;
constexpr int kAngleDecimals = 6;

const std::vector<std::string>& needed_columns() {
  static const std::vector<std::string> columns{"id", "x_mm", "y_mm"};
  return columns;
}

TargetRow target_at(CsvTable& table, std::size_t row) {
  TargetRow target{
      table.text(row, "id"),
      Eigen::Vector2d(table.number(row, "x_mm"), table.number(row, "y_mm")) * kMillimetre,
      std::nullopt};
  if (const auto phi_deg = table.optional_number(row, "phi_deg")) target.phi_d = *phi_deg * kDegree;
  return target;
}

bool has_number(const std::vector<std::string>& fields) {
  return std::any_of(fields.begin(), fields.end(),
                     [](const std::string& field) { return finite_number(field).has_value(); });
}

}  // namespace

std::vector<TargetRow> read_targets(const std::filesystem::path& path) {
  CsvTable table = CsvTable::read(path, kKind, needed_columns());
  std::vector<TargetRow> rows;
  for (std::size_t i = 0; i < table.size(); ++i) rows.push_back(target_at(table, i));
  table.require_distinct_ids();
  table.throw_if_faulty_or_empty();
  return rows;
}

std::string targets_header() {
  return CsvWriter(kKind, {"id", "x_mm", "y_mm", "phi_deg"}).text();
}

std::string target_line(const TargetRow& row) {
  const Eigen::Vector2d mm = row.p_d / kMillimetre;
  const std::string phi =
      row.phi_d ? fmt::format("{:.{}f}", *row.phi_d / kDegree, kAngleDecimals) : "";
  return fmt::format("{},{:.{}f},{:.{}f},{}\n", row.id, mm.x(), kMillimetreDecimals, mm.y(),
                     kMillimetreDecimals, phi);
}

TargetLines::TargetLines(const std::string& source, std::set<std::string> taken)
    : empty_(source, kKind, needed_columns()), taken_(std::move(taken)) {}

std::optional<TargetRow> TargetLines::next(const std::string& line) {
  ++line_;
  std::string row = line;
  const std::vector<std::string> fields = split_fields(line);
  if (!has_columns() && has_number(fields) && fields.front()[0] != '#') {
    empty_.add_line("id,x_mm,y_mm,phi_deg", line_);
    fourth_is_optional_ = true;
  }
  if (fourth_is_optional_ && fields.size() == needed_columns().size()) row += ',';
  CsvTable table = empty_;
  const bool had_columns = has_columns();
  table.add_line(row, line_);
  if (!had_columns) {
    empty_ = table;
    return std::nullopt;
  }
  if (table.size() == 0) {
    table.throw_if_faulty();
    return std::nullopt;
  }
  TargetRow target = target_at(table, 0);
  if (taken_.count(target.id) != 0)
    table.add_fault(0, fmt::format("the id '{}' stands twice; ids must differ", target.id));
  table.require_distinct_ids();
  table.throw_if_faulty();
  taken_.insert(target.id);
  return target;
}

}  // namespace planar
