#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/servo/servo_result.h"

namespace planar {

// The table steps.csv grows: the header first, then a line at a time.

std::string steps_header();
std::string step_line(const std::string& id, const ServoStep& step);

/// One step on the way to a target: the distance to it by the servo's own view, metres. Empty where
/// the tool was not measured.
struct StepError {
  std::string target;
  int step{0};  ///< number of corrections made before
  std::optional<double> error;
};

/// Reads what steps.csv says of each step's error. Throws InputError naming FILE:LINE of each bad
/// row, and for a missing file.
std::vector<StepError> read_step_errors(const std::filesystem::path& path);

}  // namespace planar
