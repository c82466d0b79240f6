#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "planar_servo/files/tables/target_table.h"

namespace planar {

/// A targets.csv to which taught places are appended, a whole line at a time.
class TaughtTargets {
 public:
  /// Continues the file that is there. A file that is empty or missing is begun with the first
  /// target. Throws InputError naming bad rows, when the columns are not id, x_mm, y_mm, phi_deg in
  /// this order, when the last line has no end, and when the file cannot be written.
  explicit TaughtTargets(std::filesystem::path path);

  /// Appends a target. Throws InputError for an id that is taken or cannot be one; the file is then
  /// unchanged.
  void append(const TargetRow& target);

 private:
  std::filesystem::path path_;
  std::set<std::string> ids_;
};

}  // namespace planar
