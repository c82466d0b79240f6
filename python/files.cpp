#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/table_columns.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar::python {
namespace {

namespace fs = std::filesystem;

/// Has the reader of this kind check the whole file, as the programs do. Kinds that only programs
/// write, such as run.yaml, have none.
void check_by_reader(const fs::path& path, const std::string& kind) {
  if (kind == "cell") read_cell(path);
  if (kind == "camera") read_camera(path);
  if (kind == "workplane") read_workplane(path);
  if (kind == "tool") read_tool(path);
  if (kind == "map") read_map(path);
  if (kind == "health") read_health(path);
  if (kind == "arm") read_found_arm(path);
  if (kind == "arm_learned") read_learned_arm(path);
}

py::object scalar_from(const YAML::Node& node) {
  const std::string& text = node.Scalar();
  if (node.Tag() == "!") return py::str(text);  // quoted
  const char* const end = text.data() + text.size();
  long whole = 0;
  if (const auto [stop, fault] = std::from_chars(text.data(), end, whole);
      fault == std::errc() && stop == end)
    return py::int_(whole);
  double number = 0.0;
  if (const auto [stop, fault] = std::from_chars(text.data(), end, number);
      fault == std::errc() && stop == end)
    return py::float_(number);
  if (text == "true" || text == "false") return py::bool_(text == "true");
  return py::str(text);
}

py::object object_from(const YAML::Node& node, int depth = 0) {
  constexpr int kDeepest = 50;
  if (depth > kDeepest) throw InputError({"is nested more than 50 deep", "", ""});
  if (node.IsNull() || !node.IsDefined()) return py::none();
  if (node.IsScalar()) return scalar_from(node);
  if (node.IsSequence()) {
    py::list items;
    for (const YAML::Node& item : node) items.append(object_from(item, depth + 1));
    return std::move(items);
  }
  py::dict keys;
  for (const auto& entry : node)
    keys[py::str(entry.first.Scalar())] = object_from(entry.second, depth + 1);
  return std::move(keys);
}

py::dict read_yaml(const fs::path& path) {
  const std::string text = read_file(path);
  const std::string kind(kind_of_text(text));
  if (kind.empty())
    throw InputError({"has no line 'format: planar-servo/KIND/1' among its first four",
                      "a YAML file of planar-servo is needed; read_table() reads tables", path});
  check_by_reader(path, kind);
  try {
    const YAML::Node document = YAML::Load(text);
    if (!document.IsMap())
      throw InputError({"is no map of keys",
                        "a YAML file of planar-servo is needed; read_table() reads tables", path});
    return object_from(document);
  } catch (const YAML::Exception& error) {
    throw InputError({error.what(), "a YAML file of planar-servo is needed", path});
  }
}

/// Says whether a file is as the program wrote it.
std::string seal_of(const fs::path& path, const std::string& text) {
  if (!has_checksum(kind_of_text(text)) || text.find("\nchecksum:") == std::string::npos)
    return "none";
  if (later_change(path, text)) return "changed";
  return text.find("\nedited_by_hand:") == std::string::npos ? "sound" : "edited_by_hand";
}

py::dict provenance_of(const fs::path& path) {
  const std::string text = read_file(path);
  const bool is_table = text.rfind("# format:", 0) == 0;
  py::list origins;
  for (const Origin& origin : read_origins(path))
    origins.append(py::make_tuple(name_in(kRoles, origin.role), origin.name, origin.sha256));
  py::dict told;
  told["kind"] = kind_of_text(text);
  told["maker"] = is_table ? "" : read_maker(path);
  told["made_from"] = origins;
  told["sha256"] = content_sha256(path);
  told["seal"] = is_table ? (has_changed_rows(path) ? "changed" : "none") : seal_of(path, text);
  return told;
}

/// Returns the kind that is asked for or, without one, that of the table's first line.
std::string kind_or_own(const fs::path& path, const std::string& asked) {
  const std::string kind = asked.empty() ? table_kind_of(path) : asked;
  if (kind.empty())
    throw InputError({"its first line does not say what kind of table it is",
                      fmt::format("name the kind: {}", fmt::join(table_kinds(), ", ")), path});
  return kind;
}

/// Returns the columns as (name, is a whole number, numbers) or (name, None, texts).
py::list read_columns(const fs::path& path, const std::string& kind) {
  std::vector<TableColumn> columns;
  {
    const py::gil_scoped_release release;
    columns = read_table_columns(path, kind_or_own(path, kind));
  }
  py::list told;
  for (TableColumn& column : columns) {
    if (column.kind == FieldKind::kText) {
      told.append(py::make_tuple(column.name, py::none(), column.texts));
      continue;
    }
    told.append(py::make_tuple(column.name, column.kind == FieldKind::kWholeNumber,
                               py::array_t<double>(static_cast<py::ssize_t>(column.numbers.size()),
                                                   column.numbers.data())));
  }
  return told;
}

/// Returns the columns of a structured array or of a map by their names.
py::dict columns_by_name(const py::object& table) {
  const bool is_array = py::isinstance<py::array>(table);
  py::object names = py::none();
  if (is_array) names = table.attr("dtype").attr("names");
  if (!is_array && py::hasattr(table, "keys")) names = table.attr("keys")();
  if (names.is_none())
    throw InputError(
        {is_array ? "is an array without names of columns" : "is of type " + type_name(table),
         "a structured array is needed, or a dict of the columns by their names", "table"});
  py::dict columns;
  for (const py::handle name : names) columns[py::str(name)] = table[name];
  return columns;
}

/// Takes the rows of a column and returns how many they are.
std::size_t fill(TableColumn& column, const py::object& values) {
  const std::string argument = fmt::format("table['{}']", column.name);
  if (column.kind == FieldKind::kText)
    column.texts = texts_of(argument.c_str(), values);
  else
    column.numbers = column_of(argument.c_str(), values);
  return std::max(column.texts.size(), column.numbers.size());
}

void write_table(const fs::path& path, const py::object& table, const std::string& kind) {
  const py::dict given = columns_by_name(table);
  std::vector<std::string> names;
  for (const auto& column : given) names.push_back(column.first.cast<std::string>());
  std::vector<TableColumn> columns = columns_named(names, kind);
  std::optional<std::size_t> rows;
  for (TableColumn& column : columns) {
    const std::size_t found = fill(column, given[py::str(column.name)]);
    if (found != rows.value_or(found))
      throw InputError({fmt::format("has {} rows", found),
                        fmt::format("{} has {}", columns[0].name, *rows),
                        fmt::format("table['{}']", column.name)});
    rows = found;
  }
  const py::gil_scoped_release release;
  require_writable(path, kind);
  write_file(path, table_text(columns, kind));
}

}  // namespace

void bind_files(py::module_& m) {
  m.def("_read_yaml", &read_yaml, py::arg("path"));
  m.def("_provenance", &provenance_of, py::arg("path"));
  m.def("_read_columns", &read_columns, py::arg("path"), py::arg("kind"));
  m.def("table_kinds", &table_kinds,
        "Returns the kinds of tables that read_table() reads and write_table() writes.");
  m.def("write_table", &write_table, py::arg("path"), py::arg("table"), py::arg("kind"),
        "Writes a CSV table that the programs accept, with kind, one of table_kinds(), in its\n"
        "first line and numbers with all their digits. table is a structured array such as\n"
        "read_table() returns, or a dict, or a DataFrame, of columns by their names: (N,) numbers\n"
        "in the unit of the name, NaN where there is none, or texts. Raises InputError naming\n"
        "table['COLUMN'] or table[ROW], rows from 0, for each fault, and where path is a file of\n"
        "another kind or program. Targets and plans are never replaced.");
}

}  // namespace planar::python
