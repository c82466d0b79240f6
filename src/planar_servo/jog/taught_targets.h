#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "planar_servo/files/tables/target_table.h"

namespace planar {

/// A targets.csv that grows by places shown to it, a whole line at a time.
class TaughtTargets {
 public:
  /// Goes on with the file that is there; one that is empty or missing is begun with the first
  /// target. Throws InputError naming its bad rows, when its columns are not id, x_mm, y_mm,
  /// phi_deg in this order, when its last line has no end, or when the file could not be written.
  explicit TaughtTargets(std::filesystem::path path);

  /// Throws InputError for an id that is taken or cannot be one; the file is as before then.
  void append(const TargetRow& target);

 private:
  std::filesystem::path path_;
  std::set<std::string> ids_;
};

}  // namespace planar
