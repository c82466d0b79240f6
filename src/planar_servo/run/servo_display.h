#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "planar_servo/report/live/live_view.h"
#include "planar_servo/run/servo_run.h"

namespace planar {

/// Shows every step of a servo as it is measured.
class ServoDisplay {
 public:
  /// Opens what the policy asks for; `picture` is the file that is drawn. Throws InputError when a
  /// window is asked for and no X server answers.
  ServoDisplay(DisplayPolicy policy, const std::filesystem::path& picture);

  /// Shows a step. It does nothing when nothing is to be drawn.
  void show(const ServoSight& sight);

  /// Draws the last step if it has not been drawn yet, and warns of what went wrong.
  void close();

 private:
  std::unique_ptr<LiveView> view_;  ///< null when nothing is drawn
  std::vector<Eigen::Vector2d> errors_m_;
};

}  // namespace planar
