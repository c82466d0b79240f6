#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planar_servo/base/io/csv_table.h"

namespace planar {

/// Holds a row of targets.csv: where the end point is wanted in the base frame, in metres.
struct TargetRow {
  std::string id;
  Eigen::Vector2d p_d{0.0, 0.0};
  std::optional<double> phi_d;  ///< radians
};

/// Reads targets.csv. Throws InputError naming FILE:LINE of each bad row, and for a table without
/// rows.
std::vector<TargetRow> read_targets(const std::filesystem::path& path);

/// Returns the header with the columns id, x_mm, y_mm, phi_deg.
std::string targets_header();
std::string target_line(const TargetRow& row);

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

}  // namespace planar
