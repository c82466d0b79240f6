#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planar_servo/io/csv_table.h"

namespace planar {

/// targets.csv: where the end point is wanted, in the base frame; SI inside.
struct TargetRow {
  std::string id;
  Eigen::Vector2d p_d{0.0, 0.0};
  std::optional<double> phi_d;  ///< radians
};

/// Throws InputError naming FILE:LINE of each bad row, and for a table without rows.
std::vector<TargetRow> read_targets(const std::filesystem::path& path);

/// The columns id, x_mm, y_mm, phi_deg.
std::string targets_header();
std::string target_line(const TargetRow& row);

/// The same table read as its lines arrive. A first line without any number is its header; without
/// one the columns are id, x_mm, y_mm and, where a line has a fourth field, phi_deg.
class TargetLines {
 public:
  /// `source` stands for the file in messages; `taken` are ids that a line must not have.
  explicit TargetLines(const std::string& source, std::set<std::string> taken = {});

  /// The target on the next line; empty for header, comment and blank line. Throws InputError with
  /// SOURCE:LINE, value and rule for a bad line, after which the next one can be taken, unless it
  /// was the header.
  std::optional<TargetRow> next(const std::string& line);

  /// Of the line taken last, from 1.
  int line() const { return line_; }
  bool has_columns() const { return table_.has_header(); }

 private:
  CsvTable table_;
  std::set<std::string> taken_;
  bool fourth_is_optional_{false};
  int line_{0};
};

}  // namespace planar
