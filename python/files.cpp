#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/core/error.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/checksum.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/tables/table_columns.h"

namespace planar::python {
namespace {

namespace fs = std::filesystem;

/// Returns the kind in the first line of a YAML file, `format: planar-servo/<kind>/1`.
std::string file_kind_of(const std::string& text) {
  constexpr std::string_view kBegin = "format: planar-servo/";
  std::size_t begin = text.find(kBegin);
  if (begin == std::string::npos ||
      (begin != 0 && text[begin - 1] != '\n' && text[begin - 1] != ' '))
    return "";
  begin += kBegin.size();
  return text.substr(begin, std::min(text.find('/', begin), text.find('\n', begin)) - begin);
}

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
  const std::string kind = file_kind_of(text);
  if (kind.empty())
    throw InputError({"has no line 'format: planar-servo/KIND/1'",
                      "a YAML file of planar-servo is needed", path});
  check_by_reader(path, kind);
  try {
    const YAML::Node document = YAML::Load(text);
    if (!document.IsMap())
      throw InputError({"is no map of keys", "a YAML file of planar-servo is needed", path});
    return object_from(document);
  } catch (const YAML::Exception& error) {
    throw InputError({error.what(), "a YAML file of planar-servo is needed", path});
  }
}

/// Says whether a file is as the program wrote it.
std::string seal_of(const fs::path& path, const std::string& text) {
  if (!has_checksum(file_kind_of(text)) || text.find("\nchecksum:") == std::string::npos)
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
  told["kind"] = is_table ? table_kind_of(path) : file_kind_of(text);
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

}  // namespace

void bind_files(py::module_& m) {
  m.def("_read_yaml", &read_yaml, py::arg("path"));
  m.def("_provenance", &provenance_of, py::arg("path"));
  m.def("_read_columns", &read_columns, py::arg("path"), py::arg("kind"));
  m.def("table_kinds", &table_kinds, "Returns the kinds of tables that read_table() reads.");
}

}  // namespace planar::python
