#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/io/csv_table.h"
#include "planar_servo/loop/servo/path/path.h"
#include "planar_servo/loop/servo/path/path_follower.h"

namespace planar {

/// Holds a row of targets.csv: where the end point is wanted in the base frame, in metres.
struct TargetRow {
  std::string id;
  Eigen::Vector2d p_d{0.0, 0.0};
  std::optional<double> phi_d;     ///< radians
  std::string tool{};              ///< whose tip is wanted there; empty for the usual one
  double sigma_m{0.0};             ///< of p_d per axis, by the work on which it lies and the tool
  Eigen::Vector2d p_TE{0.0, 0.0};  ///< the tip of that tool in T; see ToolTip
};

/// Reads targets.csv. Throws InputError naming FILE:LINE of each bad row, and for a table without
/// rows.
std::vector<TargetRow> read_targets(const std::filesystem::path& path);

/// Returns the header with the columns id, x_mm, y_mm, phi_deg.
std::string targets_header();
std::string target_line(const TargetRow& row);
/// Returns the whole table, with the column tool where a target names one.
std::string targets_text(const std::vector<TargetRow>& rows);

/// Reads a table of targets as its lines arrive. A first line without any number is its header. In
/// a table without a header, the columns are id, x_mm, y_mm and, where a line has a fourth field,
/// phi_deg.
class TargetLines {
 public:
  /// Begins before the first line. `source` names the file in messages, and `taken` holds the ids
  /// that no line may have.
  explicit TargetLines(const std::string& source, std::set<std::string> taken = {});

  /// Returns the target on the next line. Empty for a header, a comment and a blank line. Throws
  /// InputError with SOURCE:LINE, value and rule for a bad line, such as one without an end. The
  /// next line can be taken then, unless the bad one was the header.
  std::optional<TargetRow> next(const std::string& line, bool has_end = true);

  /// Returns the number of the line taken last, counted from 1.
  int line() const { return line_; }
  bool has_columns() const { return table_.has_header(); }

 private:
  CsvTable table_;
  std::set<std::string> taken_;
  bool fourth_is_optional_{false};
  int line_{0};
};

/// Reads path.csv, whose rows are the places that a path goes through, in the base frame: x_mm,
/// y_mm; a row with via_x_mm, via_y_mm is reached on the arc through that place, any other
/// straight; phi_deg is the tool's direction, by default `tool_orientation` (radians). Throws
/// InputError naming FILE:LINE of each row that cannot be reached from the one before it, and for
/// fewer than two rows.
Path read_path(const CsvSource& source, double tool_orientation);

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
