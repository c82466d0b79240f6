#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/loop/servo/path/path_follower.h"
#include "planar_servo/work/run/ready_cell.h"
#include "planar_servo/work/run/run_files.h"
#include "planar_servo/work/workpiece/work_watch.h"

namespace planar {

/// Returns only the errors and the number of these looks at one speed.
PathSpeedResult path_figures(const std::vector<PathLookRow>& looks);

/// Says which path is to be followed, and how.
struct PathRequest {
  std::filesystem::path file;
  Path path;
  std::vector<Guidance> guidances;
  std::vector<double> speeds_m_s{};  ///< the path is followed once at each, under each guidance
};

/// Returns speeds along a path in m/s. Throws InputError for those beyond kSlowest_m_s to
/// kFastest_m_s.
std::vector<double> path_speeds(const std::vector<double>& speeds_mm_s);

/// Returns what the path demands of the arm at each speed, beginning at the cell's home position.
/// Throws InputError, naming the place on the path, when the arm cannot follow it.
std::vector<PathDemand> require_followable(const CalibratedCell& cell, const PathRequest& request);

/// Throws InputError naming the first place on the path at which the error map is not valid.
void require_inside_map(const VisionCalibration& vision, const PathRequest& request);

/// Guides the end point of a cell along a path, and logs every look.
class PathRun {
 public:
  /// Is called at every look. It must not take long.
  using Observer = std::function<void(const PathLookRow&)>;

  /// Switches the drives on. `observer` may be empty. Throws as ReadyCell does, and InputError when
  /// the folder holds a run or another program writes there.
  PathRun(const ServoRequest& request, const PathRequest& path, CellDevices& devices,
          Observer observer = {});
  /// Does what ~ServoRun() does.
  ~PathRun();

  /// Checks the cell, goes to the path's beginning and follows it. A path that ends early has a
  /// result like the others. The first time by vision it measures the play, which is compensated
  /// from then on. Throws WorkError when a drive fails or somebody stops the arm; all looks so far
  /// are in the file then.
  const PathSpeedResult& follow(double speed_m_s, Guidance guidance);

  /// Returns why the path may not be followed again: the cell itself is in doubt.
  const std::optional<std::string>& ended_by() const { return ended_by_; }
  const std::vector<PathSpeedResult>& results() const { return results_; }
  const std::vector<PathLookRow>& looks() const { return looks_; }
  const ReadyCell& cell() const { return cell_; }

 private:
  PathResult follow_timed(const PathTiming& timing, double speed_m_s, Guidance guidance);
  /// Brings the end point to the path's beginning. Returns why it is not there, if it is not.
  std::optional<PathResult> go_to_beginning(const Joints& start, Guidance guidance);
  /// Measures the play, which is compensated from now on. Returns why the arm is not back at the
  /// path's beginning, if it is not.
  std::optional<PathResult> find_play();

  const PathRequest& path_;
  Observer observer_;
  std::shared_ptr<Judge> truth_;  ///< null unless the cell is virtual
  bool keep_going_;
  std::optional<std::string> ended_by_;
  std::optional<Eigen::Vector3d> play_rad_;  ///< once it was measured
  ReadyCell cell_;
  WorkWatch works_;
  PathFollower follower_;
  RunFolder folder_;
  FolderLock lock_;
  std::vector<PathSpeedResult> results_;
  std::vector<PathLookRow> looks_;
  GrowingFile look_table_;
  GrowingFile result_table_;
};

/// Follows a path as often as is asked for, unless the cell itself is in doubt, and logs what
/// fails. Returns whether its end was reached every time. `passed`, which may be empty, is told of
/// each time.
bool follow_path(PathRun& run, const PathRequest& path,
                 const std::function<void(const PathSpeedResult&)>& passed = {});

constexpr double kUsualSpeed_mm_s = 10.0;
constexpr double kSlowest_m_s = 1e-3;
constexpr double kFastest_m_s = 50e-3;

}  // namespace planar
