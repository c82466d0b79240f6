#include "planar_servo/files/tool_file.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/base/core/units.h"
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
  fields.rows("residuals_mm", taught.residuals, kMillimetre);
}

}  // namespace

std::string tool_tip_text(const TaughtTip& taught, const std::vector<Origin>& origins,
                          const std::string& program) {
  return record_text("tool_tip", taught, origins, program, list_fields);
}

TaughtTip read_tool_tip(const fs::path& path) {
  return read_record<TaughtTip>("tool_tip", path, list_fields);
}

std::vector<Origin> tool_tip_origins(const CellSettings& cell) {
  return {origin_of({Role::kWorkplane, cell.workplane}), origin_of({Role::kTool, cell.tool})};
}

const ToolTip& CellTools::tip(const std::string& name) {
  const auto known = tips_.find(name);
  if (known != tips_.end()) return known->second;
  const auto tool = cell_.tools.find(name);
  if (tool == cell_.tools.end()) {
    std::vector<std::string> names;
    names.reserve(cell_.tools.size());
    for (const auto& entry : cell_.tools) names.push_back(entry.first);
    throw InputError({fmt::format("names no tool '{}'", name),
                      names.empty() ? "teach one with planar-teach-tool, and name its file under "
                                      "`tools`"
                                    : fmt::format("known are {}", fmt::join(names, ", ")),
                      cell_.file, Cause::kMissing});
  }
  const TaughtTip taught = read_tool_tip(tool->second);
  require_made_with({Role::kToolTip, tool->second}, tool_tip_origins(cell_), accepts_stale_);
  return tips_.emplace(name, taught.tip).first->second;
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
