#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/io/columns.h"

namespace planar {

/// Holds one column of a table in the unit of its name: numbers, NaN where a field is empty, or
/// texts.
struct TableColumn {
  std::string name;
  FieldKind kind{FieldKind::kText};
  std::vector<double> numbers;
  std::vector<std::string> texts;
};

/// Returns the kinds of tables that read_table_columns() reads, as their first lines have them
/// (`# format: planar-servo/<kind>/1`).
std::vector<std::string> table_kinds();

/// Returns the kind in the first line of a table; empty where that says none.
std::string table_kind_of(const std::filesystem::path& path);

/// Reads a table of this kind by columns, in the order of writing; optional columns that the file
/// lacks are left out. A table without rows has empty columns. Throws InputError naming every fault
/// with FILE:LINE, and for a kind that is none of table_kinds().
std::vector<TableColumn> read_table_columns(const std::filesystem::path& path,
                                            const std::string& kind);

/// Reads the columns of a table with this schema.
template <typename Row>
std::vector<TableColumn> columns_in(const std::filesystem::path& path,
                                    const TableSchema<Row>& schema);

// Each of these reads the columns of one kind; its schema stands in the source of the table.
using ReadColumns = std::vector<TableColumn>(const std::filesystem::path& path);
ReadColumns read_cycle_columns, read_error_grid_columns, read_lamp_columns, read_pair_columns,
    read_lay_columns, read_arm_sample_columns, read_path_columns, read_path_look_columns,
    read_path_result_columns, read_plan_columns, read_frame_columns, read_result_columns,
    read_step_columns, read_target_columns, read_tracker_columns;

/// Takes the fields of a table's current row into the columns.
void take_fields(CsvTable& table, std::vector<TableColumn>& columns);

template <typename Row>
std::vector<TableColumn> columns_in(const std::filesystem::path& path,
                                    const TableSchema<Row>& schema) {
  TableFile<Row> table(path, schema);
  const Columns every = schema.columns();
  std::vector<TableColumn> columns;
  for (const WrittenField& field : every.written())
    if (field.need == Column::kRequired || table.has_column(field.column))
      columns.push_back({field.column, field.kind, {}, {}});
  for (Row row; table.next(row);) take_fields(table, columns);
  table.throw_if_faulty();
  return columns;
}

}  // namespace planar
