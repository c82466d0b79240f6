#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "planar_servo/calibration/tool_offsets.h"
#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/core/names.h"
#include "planar_servo/machine/cell_devices.h"

namespace planar {

/// What a judge says of the tool at rest, base frame.
struct JudgedTip {
  Eigen::Vector2d p{0.0, 0.0};
  std::optional<double> phi{};  ///< empty where the judge does not see the tool's direction
};

/// Says where the end point really is, by other means than the cell's own vision.
class Judge {
 public:
  virtual ~Judge() = default;

  /// Returns the end point, or nothing where there is no answer. The tool rests at the target `id`;
  /// `seen` is where the cell's vision sees it.
  virtual std::optional<JudgedTip> judge(const std::string& id, const TipPose& seen) = 0;
  /// Returns the standard uncertainty of an answer per axis, metres: 0 for a truth.
  virtual double sigma() const = 0;
};

/// Who judges a cell.
enum class JudgeKind { kTruth, kTracker };

constexpr Named<JudgeKind> kJudgeKinds[] = {{JudgeKind::kTruth, "truth"},
                                            {JudgeKind::kTracker, "tracker"}};

/// Returns who judges this cell: its truth if it is virtual, or else its tracker. Throws InputError
/// with a remedy when it has neither, or when its tracker cannot be tied to the end point.
JudgeKind judge_of(const CellSettings& cell, const ToolOffsets& tool);

/// Returns the judge. A tracker's readings also go to the table `readings`, which grows. It reads
/// the monuments first, and then waits for the reflector on the tool. Throws WorkError when they
/// cannot be read.
std::unique_ptr<Judge> make_judge(JudgeKind kind, const CellSettings& cell, const ToolOffsets& tool,
                                  CellDevices& devices, const std::filesystem::path& readings,
                                  std::function<bool()> stop);

}  // namespace planar
