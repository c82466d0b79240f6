#pragma once

#include <CLI/App.hpp>
#include <array>

#include "planar_servo/hardware/robot/homing.h"

namespace planar {

/// What a program's options say of drives that do not know their position.
struct HomingOptions {
  bool home{false};          ///< they may search their home switches
  bool nearest_turn{false};  ///< motors found by sight are on the turn nearest to home
  bool at_marks{false};  ///< those without a switch stand at their marks when the program starts
};

/// Adds --home, --at-marks and --nearest-turn, and returns the first two.
std::array<CLI::Option*, 2> add_homing_options(CLI::App& app, HomingOptions& options);

/// Returns the answers that the options give; --at-marks holds once, because drives that lose their
/// position later stand anywhere. What they leave open is asked at a terminal if `asks` is set.
MayHome may_home(const HomingOptions& options, bool asks = true);

}  // namespace planar
