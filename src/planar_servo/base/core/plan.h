#pragma once

#include "planar_servo/base/core/text.h"

namespace planar {

/// Says what a place of a recording is for.
enum class Plan {
  kHeldBoard,  ///< a view of the board held before the camera; calibrates the camera
  kLaidBoard,  ///< a view of the calibration board laid on the plane of motion
  kTrain,      ///< the error map is fitted to it
  kTest,       ///< the error map is judged on it
  kSweep1,     ///< joint 1 alone turns; the workplane is fitted to it
  kSweep3,     ///< joint 3 alone turns; the tool's offsets are fitted to it
  kControl,    ///< a target of the closed loop
  kCheck,      ///< a place that an experiment judges by
  kPose,       ///< a place that only the camera watches; no tracker reading is asked for
};

/// All plans with the words that files have for them.
constexpr Named<Plan> kPlans[] = {
    {Plan::kHeldBoard, "grid"},  {Plan::kLaidBoard, "plane_grid"}, {Plan::kTrain, "train"},
    {Plan::kTest, "test"},       {Plan::kSweep1, "sweep1"},        {Plan::kSweep3, "sweep3"},
    {Plan::kControl, "control"}, {Plan::kCheck, "check"},          {Plan::kPose, "pose"}};

/// Returns the plan's word.
inline const char* name(Plan plan) {
  return name_in(kPlans, plan);
}

/// Returns true for a plan whose pictures show the calibration board instead of the lamps.
constexpr bool shows_board(Plan plan) {
  return plan == Plan::kHeldBoard || plan == Plan::kLaidBoard;
}

/// Returns true for a plan whose places ask for a tracker reading.
constexpr bool needs_reading(Plan plan) {
  return !shows_board(plan) && plan != Plan::kPose;
}

}  // namespace planar
