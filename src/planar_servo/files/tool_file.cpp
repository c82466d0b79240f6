#include "planar_servo/files/tool_file.h"

#include "planar_servo/core/units.h"
#include "planar_servo/files/covariance_fields.h"
#include "planar_servo/io/yaml_fields.h"

namespace planar {
namespace {

void list_fields(Fields& fields, ToolOffsets& tool) {
  constexpr double kSquareMillimetre = kMillimetre * kMillimetre;
  fields.numbers("p_TP_mm", tool.p_TP, kMillimetre);
  fields.numbers("p_TS_mm", tool.p_TS, kMillimetre);
  Eigen::Matrix<double, 5, 5> in_file = tool.covariance / kSquareMillimetre;
  list_covariance(fields, {"p_TP_x_mm", "p_TP_y_mm", "p_TS_x_mm", "p_TS_y_mm", "p_TS_z_mm"},
                  in_file);
  if (fields.reading()) tool.covariance = in_file * kMillimetre * kMillimetre;
}

}  // namespace

std::string tool_text(const ToolOffsets& tool, const std::string& program,
                      const std::vector<Origin>& origins) {
  YamlWriter yaml = YamlWriter::with_header("tool", program);
  yaml.add_inputs(input_records(origins));
  FieldWriter writer(yaml);
  ToolOffsets written = tool;
  list_fields(writer, written);
  return yaml.text();
}

ToolOffsets read_tool(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read(path, "tool");
  FieldReader reader(document.root());
  ToolOffsets tool;
  list_fields(reader, tool);
  document.throw_if_faulty();
  return tool;
}

}  // namespace planar
