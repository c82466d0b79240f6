#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/arm/joint_planner.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/experiment/loops/registered_tracker.h"
#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/offline/record/reflector_readings.h"
#include "planar_servo/run/end_point_judge.h"

namespace planar {

/// Judges the end point by the cell's tracker in place of a truth. The end point is where the
/// reflector is read, less its offset on the tool, turned to where the arm as it was found has the
/// tool at the commanded joints: no camera takes part.
class TrackerJudge {
 public:
  /// `ours` is our chain, which found the arm and the reflector's offset. What is read grows in
  /// `file`, a tracker.csv. `stop` is as in ReflectorReadings.
  TrackerJudge(const CalibratedChain& ours, Tracker& tracker, const std::filesystem::path& file,
               const std::function<bool()>& stop);

  /// Ties the tracker to the base by `seen`, which no fit has used, or, where that is empty, by a
  /// new round over the monuments. Then waits until the reflector is back on the tool. Throws what
  /// ReflectorReadings and RegisteredTracker throw, and what Tracker::await_tool() throws.
  void make_ready(const std::vector<MonumentSeen>& seen);

  /// Reads the reflector, a second time when the first attempt fails. `place` names the reading.
  /// Call make_ready() before.
  JudgedPoint judge(const std::string& place, const Joints& commanded);

  /// Returns the standard deviation of the reflector's offset on the tool, the larger of both axes,
  /// metres. The judge cannot see that error.
  double reflector_sigma() const { return reflector_sigma_; }

 private:
  TrackerAnswer read(const std::string& place, const TipPose& sent);

  CellSettings cell_;
  Tracker& tracker_;
  JointPlanner planner_;
  Eigen::Vector2d p_TS_;
  double reflector_sigma_;
  GrowingFile table_;
  ReflectorReadings readings_;
  std::optional<RegisteredTracker> registered_;
};

/// Throws InputError when a cell without a truth has no tracker that can judge, or fewer than three
/// monuments.
void require_judging_tracker(const CellSettings& cell);

}  // namespace planar
