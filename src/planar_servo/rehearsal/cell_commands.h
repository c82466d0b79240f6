#pragma once

#include <functional>
#include <string>
#include <vector>

#include "planar_servo/rehearsal/live_cell.h"

namespace planar {

/// The commands that obey_command() knows, for --help.
constexpr char kCellCommands[] =
    "'board hold N', 'board lay N' and 'board remove', N from 0; 'reflector tool' and 'reflector "
    "MONUMENT'; 'arm marks' where drives have no home switches";

/// Does what a person at the cell would do by hand, as one line says: 'board hold N' holds the
/// calibration board tilted into the camera's view and 'board lay N' lays it on the plane of
/// motion, N from 0 (see BoardPresenter); 'board remove' takes it away; 'reflector tool' and
/// 'reflector MONUMENT' place the tracker's reflector; 'arm marks' calls `put_at_marks`, which
/// returns whether it could. Returns what was done in one line, or beginning with "not understood"
/// what is allowed instead.
std::string obey_command(const std::string& line, LiveCell& cell,
                         const std::function<bool()>& put_at_marks);

/// Reads lines from an open file, without waiting longer than it is told to.
class LineInput {
 public:
  /// The descriptor stays open.
  explicit LineInput(int descriptor) : descriptor_(descriptor) {}

  /// Waits at most this long, and returns the whole lines that have come. Once the input has ended
  /// it only waits.
  std::vector<std::string> lines_within(double timeout_s);

 private:
  int descriptor_;
  bool ended_{false};
  std::string begun_;
};

}  // namespace planar
