#pragma once

#include <string>
#include <vector>

namespace planar {

/// Hears lines on an open file without waiting for more than it is told to.
class LineInput {
 public:
  /// The descriptor stays open.
  explicit LineInput(int descriptor) : descriptor_(descriptor) {}

  /// Waits so long at most, and returns the whole lines that have come. Once the input has ended it
  /// only waits.
  std::vector<std::string> lines_within(double timeout_s);

 private:
  int descriptor_;
  bool ended_{false};
  std::string begun_;
};

}  // namespace planar
