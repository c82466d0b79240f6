#include "planar_servo/files/tool_file.h"

#include "planar_servo/core/units.h"
#include "planar_servo/files/covariance_yaml.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {

std::string tool_text(const ToolOffsets& tool, const std::string& program,
                      const std::vector<std::filesystem::path>& inputs) {
  const Eigen::Vector2d p_TP = tool.p_TP / kMillimetre;
  const Eigen::Vector3d p_TS = tool.p_TS / kMillimetre;
  YamlWriter writer = YamlWriter::with_header("tool", program);
  writer.add_inputs(inputs)
      .add("p_TP_mm", std::vector<double>{p_TP.x(), p_TP.y()})
      .add("p_TS_mm", std::vector<double>{p_TS.x(), p_TS.y(), p_TS.z()});
  add_covariance(writer, {"p_TP_x_mm", "p_TP_y_mm", "p_TS_x_mm", "p_TS_y_mm", "p_TS_z_mm"},
                 tool.covariance / (kMillimetre * kMillimetre));
  return writer.text();
}

ToolOffsets read_tool(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read(path, "tool");
  const YamlNode root = document.root();
  const std::vector<double> p_TP = root.numbers("p_TP_mm", 2), p_TS = root.numbers("p_TS_mm", 3);
  ToolOffsets tool;
  tool.p_TP = Eigen::Vector2d(p_TP[0], p_TP[1]) * kMillimetre;
  tool.p_TS = Eigen::Vector3d(p_TS[0], p_TS[1], p_TS[2]) * kMillimetre;
  tool.covariance = read_covariance(root, 5) * kMillimetre * kMillimetre;
  document.throw_if_faulty();
  return tool;
}

}  // namespace planar
