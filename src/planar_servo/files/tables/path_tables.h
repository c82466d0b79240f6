#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/names.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/loop/servo/path/path.h"
#include "planar_servo/loop/servo/path/path_follower.h"

namespace planar {

/// Reads path.csv, whose rows are the places that a path goes through, in the base frame: x_mm,
/// y_mm; a row with via_x_mm, via_y_mm is reached on the arc through that place, any other
/// straight; phi_deg is the tool's direction, by default `tool_orientation` (radians). Throws
/// InputError naming FILE:LINE of each row that cannot be reached from the one before it, and for
/// fewer than two rows.
Path read_path(const std::filesystem::path& file, double tool_orientation);

/// Says what leads the end point along a path: the arm's model alone, or vision as well.
enum class Guidance { kArm, kVision };

constexpr Named<Guidance> kGuidances[] = {{Guidance::kArm, "arm"}, {Guidance::kVision, "vision"}};

/// Holds how far the end point was off its path, and behind its time, at every look that counts.
struct PathErrors {
  Summary across_m;                        ///< distance from the path
  double lag_mean_m{0.0}, lag_max_m{0.0};  ///< mean, and largest size; late is positive
};

/// Holds how a path went at one speed, a row of path_results.csv.
struct PathSpeedResult {
  Guidance guidance{Guidance::kVision};
  double speed_m_s{0.0};
  ServoStatus status{ServoStatus::kRefused};
  std::string reason;
  int looks{0};
  double seconds{0.0};
  std::optional<PathErrors> own_view, truth;
};

/// Holds a look on the path, a row of path_looks.csv.
struct PathLookRow {
  Guidance guidance{Guidance::kVision};
  double speed_m_s{0.0};
  PathLook look;
  std::optional<PathOffset> truth;  ///< where a truth watches: where it was when this was reported

  /// Return how far the end point was behind its time, metres.
  double lag_m() const { return look.along_m - look.seen.along_m; }
  std::optional<double> lag_truth_m() const;
};

// Both tables grow: the header first, then a line at a time.
std::string path_looks_header();
std::string path_look_line(const PathLookRow& row);
std::string path_results_header(const std::vector<std::string>& remarks);
std::string path_result_line(const PathSpeedResult& result);

}  // namespace planar
