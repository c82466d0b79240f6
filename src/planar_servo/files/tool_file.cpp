#include "planar_servo/files/tool_file.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/files/matrix_fields.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

void list_fields(Fields& fields, TaughtTip& taught) {
  fields.numbers("p_TE_mm", taught.tip.p_TE, kMillimetre);
  Eigen::Matrix2d in_mm2 = taught.tip.covariance / (kMillimetre * kMillimetre);
  list_covariance(fields, {"x_mm", "y_mm"}, in_mm2);
  if (fields.reading()) taught.tip.covariance = in_mm2 * (kMillimetre * kMillimetre);
  fields.number("sigma_mm", taught.sigma, kMillimetre, Range::positive());
  fields.numbers("mark_mm", taught.mark_B, kMillimetre);
  fields.rows("residuals_mm", taught.residuals, [](RowFields& row, Eigen::Vector2d& residual) {
    for (double& component : residual) row.number(component, kMillimetre);
  });
}

/// Reads the file of a tool of the cell, and refuses one of another calibration.
ToolTip tip_of(const std::string& name, const CellSettings& cell, bool accepts_stale) {
  const auto tool = cell.tools.find(name);
  if (tool == cell.tools.end()) {
    std::vector<std::string> known;
    known.reserve(cell.tools.size());
    for (const auto& entry : cell.tools) known.push_back(entry.first);
    throw InputError({fmt::format("names no tool '{}'", name),
                      known.empty() ? "teach one with planar-teach-tool, and name its file under "
                                      "`tools`"
                                    : fmt::format("known are {}", fmt::join(known, ", ")),
                      cell.file});
  }
  const TaughtTip taught = read_tool_tip(tool->second);
  require_made_with({Role::kToolTip, tool->second}, tool_tip_origins(cell), accepts_stale);
  return taught.tip;
}

}  // namespace

std::string tool_tip_text(const TaughtTip& taught, const std::vector<Origin>& origins,
                          const std::string& program) {
  YamlWriter yaml("tool_tip", program);
  yaml.add_inputs(input_records(origins));
  TaughtTip written = taught;
  list_fields(yaml, written);
  return yaml.text();
}

TaughtTip read_tool_tip(const fs::path& path) {
  YamlReader reader(path, "tool_tip");
  TaughtTip taught;
  list_fields(reader, taught);
  reader.throw_if_faulty();
  return taught;
}

std::vector<Origin> tool_tip_origins(const CellSettings& cell) {
  return {origin_of({Role::kWorkplane, cell.workplane}), origin_of({Role::kTool, cell.tool})};
}

const ToolTip& CellTools::tip(const std::string& name) {
  const auto known = tips_.find(name);
  if (known != tips_.end()) return known->second;
  return tips_.emplace(name, tip_of(name, cell_, accepts_stale_)).first->second;
}

std::vector<TargetRow> CellTools::with_tips(std::vector<TargetRow> targets) {
  for (TargetRow& target : targets) {
    const std::string& name = target.tool.empty() ? usual_ : target.tool;
    if (name.empty()) continue;
    const ToolTip& wanted = tip(name);
    target.p_TE = wanted.p_TE;
    target.sigma_m = std::hypot(target.sigma_m, per_axis(wanted.covariance));
  }
  return targets;
}

}  // namespace planar
