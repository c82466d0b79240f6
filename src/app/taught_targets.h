#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "files/target_table.h"
#include "text/growing_file.h"

namespace planar {

/// A targets.csv that grows by places shown to it, a whole line at a time.
class TaughtTargets {
 public:
  /// Goes on with the file that is there. Throws InputError naming its bad rows, when its columns
  /// are not id, x_mm, y_mm, phi_deg in this order, or when its last line has no end.
  explicit TaughtTargets(const std::filesystem::path& path);

  /// Throws InputError for an id that is taken or cannot be one; the file is as before then.
  void append(const TargetRow& target);

 private:
  std::set<std::string> ids_;
  GrowingFile file_;
};

}  // namespace planar
