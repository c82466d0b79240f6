#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/report/live_view.h"
#include "planar_servo/run/servo_run.h"

namespace planar {

/// What `--display` asks for.
enum class DisplayPolicy {
  kNone,  ///< nothing is drawn
  kAuto,  ///< a picture file, and a window where an X server answers
  kX,     ///< both, or an error
};

/// "none", "auto" or "x".
DisplayPolicy display_policy_named(const std::string& name);

/// Shows every step of a servo as it is measured.
class ServoDisplay {
 public:
  /// Throws InputError when a window is asked for and no X server answers.
  ServoDisplay(DisplayPolicy policy, const std::filesystem::path& picture);

  void show(const ServoSight& sight);

  /// Draws the last step, if it has not been, and warns of what went wrong.
  void close();

 private:
  std::unique_ptr<LiveView> view_;  ///< none: nothing is drawn
  std::vector<Eigen::Vector2d> errors_m_;
};

}  // namespace planar
