#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// Returns the text of a tool's file: where its tip is, and the mark at which it was taught.
std::string tool_tip_text(const TaughtTip& taught, const std::vector<Origin>& origins,
                          const std::string& program);

/// Reads it. Throws InputError naming every fault.
TaughtTip read_tool_tip(const std::filesystem::path& path);

/// Returns what a tool's file is made from: of the cell what places the end point.
std::vector<Origin> tool_tip_origins(const CellSettings& cell);

/// The tools of a cell that targets name, each read once, when the first target names it.
class CellTools {
 public:
  /// Takes the cell, which must outlive it, and the tool of targets that name none; without either
  /// the end point P is the tip.
  CellTools(const CellSettings& cell, std::string usual, bool accepts_stale)
      : cell_(cell), usual_(std::move(usual)), accepts_stale_(accepts_stale) {}

  /// Returns the targets with the tips of their tools. Throws InputError for a name that the cell
  /// does not have, for a file with faults, and for one that was taught with another calibration,
  /// unless that is accepted.
  std::vector<TargetRow> with_tips(std::vector<TargetRow> targets);

 private:
  const ToolTip& tip(const std::string& name);

  const CellSettings& cell_;
  std::string usual_;
  bool accepts_stale_;
  std::map<std::string, ToolTip> tips_;
};

}  // namespace planar
