#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/tables/target_table.h"

namespace planar {

/// A targets.csv to which taught places are appended, a whole line at a time.
class TaughtTargets {
 public:
  /// Continues the file that is there. A file that is empty or missing is begun with the first
  /// target. Throws InputError naming bad rows, when the columns are not id, x_mm, y_mm and perhaps
  /// phi_deg in this order, when the last line has no end, and when the file cannot be written.
  explicit TaughtTargets(std::filesystem::path path);

  /// Appends a target, without its direction in a table without directions. Throws InputError for
  /// an id that is taken or cannot be one; the file is then unchanged.
  void append(const TargetRow& target);

  /// Throws InputError that names the ids there are for an id that is not among them.
  const TargetRow& at(const std::string& id) const;

 private:
  std::filesystem::path path_;
  bool has_phi_{true};
  std::vector<TargetRow> targets_;
};

}  // namespace planar
