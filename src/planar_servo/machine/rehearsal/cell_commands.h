#pragma once

#include <functional>
#include <string>
#include <vector>

#include "planar_servo/machine/rehearsal/live_cell.h"

namespace planar {

/// The commands that obey_command() knows, for --help.
constexpr char kCellCommands[] =
    "'board hold N', 'board lay N' and 'board remove', N from 0; 'reflector tool' and 'reflector "
    "MONUMENT'; 'camera off' and 'camera on'; 'arm marks' where drives have no home switches";

/// What is done by hand to devices that are not the cell's own.
struct CellHands {
  /// Turns the arm to its marks, and returns whether it could.
  std::function<bool()> put_at_marks;
  /// Switches the camera's power.
  std::function<void(bool on)> power_camera;
};

/// Does what a person at the cell would do by hand, as one line says: 'board hold N' holds the
/// calibration board tilted into the camera's view and 'board lay N' lays it on the plane of
/// motion, N from 0 (see BoardPresenter); 'board remove' takes it away; 'reflector tool' and
/// 'reflector MONUMENT' place the tracker's reflector; 'camera off', 'camera on' and 'arm marks'
/// are left to `hands`. Returns what was done in one line, or beginning with "not understood" what
/// is allowed instead.
std::string obey_command(const std::string& line, LiveCell& cell, const CellHands& hands);

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
