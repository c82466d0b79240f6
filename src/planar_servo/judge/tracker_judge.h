#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/devices/judge.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/judge/reflector_readings.h"
#include "planar_servo/judge/registered_tracker.h"
#include "planar_servo/tool/tool_offsets.h"

namespace planar {

/// Judges the end point by the cell's tracker: P = X_BL reading - R(phi) p_TS, where the tool is
/// supposed to have the direction phi.
class TrackerJudge final : public Judge {
 public:
  /// `tool` says where the reflector sits. What is read grows in `file`, a tracker.csv that is made
  /// with the first reading. `stop` is as in ReflectorReadings.
  TrackerJudge(const CellSettings& cell, const ToolOffsets& tool, Tracker& tracker,
               const std::filesystem::path& file, const std::function<bool()>& stop);

  /// Ties the tracker to the base by `seen`, which no fit has used, or, where that is empty, by a
  /// new round over the monuments. Then waits until the reflector is back on the tool. Throws what
  /// ReflectorReadings and RegisteredTracker throw, and what Tracker::await_tool() throws.
  void make_ready(const std::vector<MonumentSeen>& seen = {});

  /// Supposes the tool where these have it at the commanded joints, not where it is seen: for loops
  /// whose vision is judged as well.
  void suppose(std::function<TipPose(const Eigen::Vector3d& theta_c)> forward) {
    forward_ = std::move(forward);
  }
  /// Puts a name before those of the places that are judged from now on.
  void name_loop(const std::string& loop) { loop_ = loop + " "; }

  JudgeKind kind() const override { return JudgeKind::kTracker; }
  /// Reads the reflector, up to three times until a reading is good: at rest, moved as the tool
  /// has, and near where the tool is supposed to be. Nobody is asked again who chose to do without.
  /// Makes itself ready where make_ready() was not called.
  JudgedTip judge(const std::string& id, const Standing& standing) override;

  /// Returns the standard deviation of the reflector's offset, the larger one of both axes.
  double common_sigma() const override;

 private:
  JudgedTip tip_of(const TrackerReading& reading, const TipPose& supposed) const;

  CellSettings cell_;
  ToolOffsets tool_;
  Tracker& tracker_;
  std::filesystem::path file_;
  std::function<bool()> stop_;
  std::optional<GrowingFile> table_;
  std::optional<ReflectorReadings> readings_;
  std::optional<RegisteredTracker> registered_;
  std::function<TipPose(const Eigen::Vector3d& theta_c)> forward_;
  std::string loop_;
};

/// Throws InputError with a remedy when the tracker of a cell without a truth cannot judge it:
/// there is none, or fewer than three monuments tie it to the base.
void require_judging_tracker(const CellSettings& cell);

}  // namespace planar
