#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "planar_servo/base/io/columns.h"

namespace planar {

/// Holds one column of a table in the unit of its name: numbers, NaN where a field is empty, or
/// texts.
struct TableColumn {
  std::string name;
  FieldKind kind{FieldKind::kText};
  std::vector<double> numbers;
  std::vector<std::string> texts;
};

/// Returns the kinds of tables that are read and written by columns, as their first lines have them
/// (`# format: planar-servo/<kind>/1`).
std::vector<std::string> table_kinds();

/// Returns the kind in the first line of a table; empty where that says none.
std::string table_kind_of(const std::filesystem::path& path);

/// Returns whether a file is a table that may be of this kind and has this column. False for what
/// cannot be read.
bool is_table_with(const std::string& column, const std::filesystem::path& path,
                   const std::string& kind);

/// Reads a table of this kind by columns, in the order of writing; optional columns that the file
/// lacks are left out. A table without rows has empty columns. Throws InputError naming every fault
/// with FILE:LINE, and for a kind that is none of table_kinds().
std::vector<TableColumn> read_table_columns(const std::filesystem::path& path,
                                            const std::string& kind);

/// Returns the columns of a table of this kind that have these names, in the order of writing and
/// without rows. Throws InputError for a kind that is none of table_kinds(), at `kind`, and, at
/// `table`, for a name that is no column's and for a missing column.
std::vector<TableColumn> columns_named(const std::vector<std::string>& names,
                                       const std::string& kind);

/// Returns the text of a table with these columns, equally long; a number is written with all its
/// digits. Throws InputError naming every fault that a reader of the table finds at `table[ROW]`,
/// counted from 0, and for a table without rows.
std::string table_text(const std::vector<TableColumn>& columns, const std::string& kind);

/// A table's schema without the type of its rows.
struct TableForm {
  const char* kind;
  Columns columns;  ///< with the fields of an empty row
  UnendedRow unended;
  RowIds ids;
  std::function<void(Columns&)> read_row;  ///< whose faults the table collects
};

// Each of these returns the forms of one source, where their schemas stand.
std::vector<TableForm> pair_forms();
std::vector<TableForm> recording_forms();
std::vector<TableForm> result_forms();
std::vector<TableForm> target_forms();
TableForm error_grid_form();
TableForm tracker_form();

template <typename Row>
TableForm form_of(const TableSchema<Row>& schema) {
  return {schema.kind, schema.columns(), schema.unended, schema.ids,
          [list = schema.list_columns](Columns& columns) {
            Row row{};
            list(columns, row);
          }};
}

}  // namespace planar
