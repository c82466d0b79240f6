#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// What a place of a recording serves.
enum class Plan {
  kHeldBoard,  ///< a view of the calibration board held into the view; calibrates the camera
  kLaidBoard,  ///< a view of the calibration board laid on the plane of motion
  kTrain,      ///< the error map is fitted to it
  kTest,       ///< the error map is judged on it
  kSweep1,     ///< joint 1 alone turns; the workplane is fitted to it
  kSweep3,     ///< joint 3 alone turns; the tool's offsets are fitted to it
  kControl,    ///< a target of the closed loop
  kCheck,      ///< a place that an experiment judges by
};

/// The word that files have for it: "grid", "plane_grid", "train", "test", "sweep1", "sweep3",
/// "control", "check".
const char* name(Plan plan);

/// The plan with this name; empty when there is none.
std::optional<Plan> plan_named(std::string_view name);

/// All plans, in the order of their names' list.
std::vector<Plan> all_plans();

/// The names of all plans.
std::vector<std::string> plan_names();

/// True of a plan whose pictures show the calibration board instead of the lamps.
bool shows_board(Plan plan);

}  // namespace planar
