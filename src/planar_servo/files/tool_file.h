#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/geometry/tool/tool_tip.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// Returns the text of a tool's file: where its tip is, and the mark at which it was taught.
std::string tool_tip_text(const TaughtTip& taught, const std::vector<Origin>& origins,
                          const std::string& program);

/// Reads it. Throws InputError naming every fault.
TaughtTip read_tool_tip(const std::filesystem::path& path);

/// Returns what a tool's file is made from: of the cell what places the end point.
std::vector<Origin> tool_tip_origins(const CellSettings& cell);

/// Returns the targets with the tips of the tools that they name, or of the cell's tool `usual`
/// where they name none; without either the end point P is the tip. Throws InputError for a name
/// that the cell does not have, for a file with faults, and for one that was taught with another
/// calibration, unless that is accepted.
std::vector<TargetRow> with_tools(std::vector<TargetRow> targets, const CellSettings& cell,
                                  const std::string& usual, bool accepts_stale);

}  // namespace planar
