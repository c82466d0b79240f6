#include "planar_servo/files/tool_file.h"

#include "planar_servo/core/units.h"
#include "planar_servo/files/matrix_fields.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {
namespace {

constexpr double kSquareMillimetre = kMillimetre * kMillimetre;

/// Visits the covariance of the end point alone, which is all where no tracker saw the reflector.
void list_end_point_covariance(Fields& fields, ToolOffsets& tool) {
  Eigen::Matrix2d in_file = tool.covariance.topLeftCorner<2, 2>() / kSquareMillimetre;
  list_covariance(fields, {"p_TP_x_mm", "p_TP_y_mm"}, in_file);
  if (fields.reading()) tool.covariance.topLeftCorner<2, 2>() = in_file * kSquareMillimetre;
}

void list_fields(Fields& fields, ToolOffsets& tool) {
  fields.numbers("p_TP_mm", tool.p_TP, kMillimetre);
  tool.reflector_known = fields.given("p_TS_mm", tool.reflector_known);
  if (!tool.reflector_known) return list_end_point_covariance(fields, tool);
  fields.numbers("p_TS_mm", tool.p_TS, kMillimetre);
  Eigen::Matrix<double, 5, 5> in_file = tool.covariance / kSquareMillimetre;
  list_covariance(fields, {"p_TP_x_mm", "p_TP_y_mm", "p_TS_x_mm", "p_TS_y_mm", "p_TS_z_mm"},
                  in_file);
  if (fields.reading()) tool.covariance = in_file * kSquareMillimetre;
}

}  // namespace

std::string tool_text(const ToolOffsets& tool, const std::string& program,
                      const std::vector<Origin>& origins) {
  YamlWriter yaml("tool", program);
  yaml.add_inputs(input_records(origins));
  ToolOffsets written = tool;
  list_fields(yaml, written);
  return yaml.text();
}

ToolOffsets read_tool(const std::filesystem::path& path) {
  YamlReader reader(path, "tool");
  ToolOffsets tool;
  list_fields(reader, tool);
  reader.throw_if_faulty();
  return tool;
}

}  // namespace planar
