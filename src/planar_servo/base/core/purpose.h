#pragma once

#include "planar_servo/base/core/text.h"

namespace planar {

/// Says what a place of a recording is for.
enum class Purpose {
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

/// All purposes with the words that files have for them.
constexpr Named<Purpose> kPurposes[] = {
    {Purpose::kHeldBoard, "grid"},  {Purpose::kLaidBoard, "plane_grid"},
    {Purpose::kTrain, "train"},     {Purpose::kTest, "test"},
    {Purpose::kSweep1, "sweep1"},   {Purpose::kSweep3, "sweep3"},
    {Purpose::kControl, "control"}, {Purpose::kCheck, "check"},
    {Purpose::kPose, "pose"}};

inline const char* name(Purpose plan) {
  return name_in(kPurposes, plan);
}

/// Returns true for places whose pictures show the calibration board instead of the lamps.
constexpr bool shows_board(Purpose plan) {
  return plan == Purpose::kHeldBoard || plan == Purpose::kLaidBoard;
}

/// Returns true for places that ask for a tracker reading.
constexpr bool needs_reading(Purpose plan) {
  return !shows_board(plan) && plan != Purpose::kPose;
}

/// The state of a place that is to be recorded.
enum class PlaceMark { kToDo, kDone, kLeftOut };

/// The words that the page has for them.
constexpr Named<PlaceMark> kPlaceMarks[] = {
    {PlaceMark::kToDo, "to_do"}, {PlaceMark::kDone, "done"}, {PlaceMark::kLeftOut, "left_out"}};

}  // namespace planar
