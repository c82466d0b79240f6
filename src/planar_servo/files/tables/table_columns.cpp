#include "planar_servo/files/tables/table_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <string_view>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"

namespace planar {
namespace {

/// All forms by their kinds.
const std::vector<TableForm>& forms() {
  static const std::vector<TableForm> all = [] {
    std::vector<TableForm> forms{error_grid_form(), tracker_form()};
    for (const auto& of : {pair_forms, recording_forms, result_forms, target_forms})
      for (TableForm& form : of()) forms.push_back(std::move(form));
    std::sort(forms.begin(), forms.end(), [](const TableForm& a, const TableForm& b) {
      return std::string_view(a.kind) < b.kind;
    });
    return forms;
  }();
  return all;
}

const TableForm& form_named(const std::string& kind, const std::string& where) {
  for (const TableForm& form : forms())
    if (kind == form.kind) return form;
  throw InputError({fmt::format("'{}' is no kind of table", kind),
                    fmt::format("allowed are {}", fmt::join(table_kinds(), ", ")), where});
}

/// Reads a table's current row by the rules of its kind; `taken` holds the ids of those before it.
void check_row(const TableForm& form, CsvTable& table, std::set<std::string>& taken) {
  Columns columns(table);
  form.read_row(columns);
  if (form.ids == RowIds::kAny) return;
  table.require_id_not_in(taken);
  taken.emplace(table.text("id"));
}

/// Takes the fields of a table's current row into the columns.
void take_fields(CsvTable& table, std::vector<TableColumn>& columns) {
  for (TableColumn& column : columns) {
    if (column.kind == FieldKind::kText)
      column.texts.emplace_back(table.text(column.name));
    else
      column.numbers.push_back(
          table.optional_number(column.name).value_or(std::numeric_limits<double>::quiet_NaN()));
  }
}

std::vector<TableColumn> empty_columns(const TableForm& form, const CsvTable& table) {
  std::vector<TableColumn> columns;
  for (const WrittenField& field : form.columns.written())
    if (table.has_column(field.column)) columns.push_back({field.column, field.kind, {}, {}});
  return columns;
}

/// A table that is yet to be written; its rows are counted from 0.
class ComingTable : public CsvTable {
 public:
  ComingTable(const TableForm& form, const std::vector<std::string>& names)
      : CsvTable("table", form.kind, form.columns.names(Column::kRequired), {},
                 form.columns.names(Column::kOptional)) {
    if (names.empty())
      throw InputError(
          {"has no columns", "needed are " + required_columns(), "table", Cause::kMissing});
    std::string header;
    for (const std::string& name : names) header += (header.empty() ? "" : ",") + csv_field(name);
    take_line(header, -1);
  }

 protected:
  std::string row() const override {
    return fmt::format("{}[{}]", source().string(), line_number());
  }
};

std::string field_of(const TableColumn& column, std::size_t row) {
  if (column.kind == FieldKind::kText) return csv_field(column.texts.at(row));
  const double number = column.numbers.at(row);
  return std::isnan(number) ? "" : fmt::format("{}", number + 0.0);  // -0.0 becomes 0
}

}  // namespace

std::vector<std::string> table_kinds() {
  std::vector<std::string> kinds;
  for (const TableForm& form : forms()) kinds.emplace_back(form.kind);
  return kinds;
}

std::string table_kind_of(const std::filesystem::path& path) {
  std::ifstream in = open_file(path);
  std::string line;
  std::getline(in, line);
  return line.rfind('#', 0) == 0 ? std::string(kind_of_text(line)) : "";
}

bool is_table_with(const std::string& column, const std::filesystem::path& path,
                   const std::string& kind) try {
  return CsvFile(path, kind, {column}).has_column(column);
} catch (const InputError&) {
  return false;
}

std::vector<TableColumn> read_table_columns(const std::filesystem::path& path,
                                            const std::string& kind) {
  const TableForm& form = form_named(kind, path);
  CsvFile table(path, form.kind, form.columns.names(Column::kRequired), {}, form.unended,
                form.columns.names(Column::kOptional));
  std::vector<TableColumn> columns = empty_columns(form, table);
  for (std::set<std::string> taken; table.next_row(); take_fields(table, columns))
    check_row(form, table, taken);
  table.throw_if_faulty();
  return columns;
}

std::vector<TableColumn> columns_named(const std::vector<std::string>& names,
                                       const std::string& kind) {
  const TableForm& form = form_named(kind, "kind");
  std::vector<TableColumn> columns = empty_columns(form, ComingTable(form, names));
  const std::vector<std::string> known = form.columns.names();
  for (const std::string& name : names)
    if (std::count(known.begin(), known.end(), name) == 0)
      throw InputError({fmt::format("has a column '{}'", name),
                        fmt::format("{} has {}", kind, fmt::join(known, ", ")), "table"});
  return columns;
}

std::string table_text(const std::vector<TableColumn>& columns, const std::string& kind) {
  const TableForm& form = form_named(kind, "kind");
  std::vector<std::string> names;
  names.reserve(columns.size());
  for (const TableColumn& column : columns) names.push_back(column.name);
  ComingTable table(form, names);
  std::set<std::string> taken;
  std::string text = csv_header(kind, names);
  const std::size_t rows = std::max(columns.at(0).texts.size(), columns.at(0).numbers.size());
  for (std::size_t row = 0; row < rows; ++row) {
    std::string line;
    for (const TableColumn& column : columns) line += field_of(column, row) + ',';
    line.pop_back();
    if (table.take_line(line, static_cast<int>(row))) check_row(form, table, taken);
    text += line + '\n';
  }
  table.throw_if_faulty_or_empty();
  return text;
}

}  // namespace planar
