#include "planar_servo/tables/table_columns.h"

#include <fmt/format.h>

#include <fstream>
#include <limits>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/tables/grid_exports.h"

namespace planar {
namespace {

struct TableReader {
  const char* kind;
  ReadColumns* read;
};

constexpr TableReader kReaders[] = {{"cycles", read_cycle_columns},
                                    {kErrorGridKind, read_error_grid_columns},
                                    {"frames", read_frame_columns},
                                    {"lamps", read_lamp_columns},
                                    {"lays", read_lay_columns},
                                    {"pairs", read_pair_columns},
                                    {"path", read_path_columns},
                                    {"path_looks", read_path_look_columns},
                                    {"path_results", read_path_result_columns},
                                    {"plan", read_plan_columns},
                                    {"results", read_result_columns},
                                    {"samples", read_arm_sample_columns},
                                    {"steps", read_step_columns},
                                    {"targets", read_target_columns},
                                    {"tracker", read_tracker_columns}};

}  // namespace

std::vector<std::string> table_kinds() {
  std::vector<std::string> kinds;
  for (const TableReader& reader : kReaders) kinds.emplace_back(reader.kind);
  return kinds;
}

std::string table_kind_of(const std::filesystem::path& path) {
  std::ifstream in = open_file(path);
  std::string line;
  std::getline(in, line);
  return line.rfind('#', 0) == 0 ? std::string(kind_of_text(line)) : "";
}

std::vector<TableColumn> read_table_columns(const std::filesystem::path& path,
                                            const std::string& kind) {
  for (const TableReader& reader : kReaders)
    if (kind == reader.kind) return reader.read(path);
  throw InputError({fmt::format("'{}' is no kind of table", kind),
                    fmt::format("allowed are {}", fmt::join(table_kinds(), ", ")), path});
}

void take_fields(CsvTable& table, std::vector<TableColumn>& columns) {
  for (TableColumn& column : columns) {
    if (column.kind == FieldKind::kText)
      column.texts.emplace_back(table.text(column.name));
    else
      column.numbers.push_back(
          table.optional_number(column.name).value_or(std::numeric_limits<double>::quiet_NaN()));
  }
}

}  // namespace planar
