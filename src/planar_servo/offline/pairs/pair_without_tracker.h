#pragma once

#include "planar_servo/offline/pairs/pair_tracker.h"

namespace planar {

/// Returns whether the request has a reading of the reflector on the tool.
bool has_tool_readings(const PairTrackerRequest& request);

/// Makes unattended pairs of a recording that no tracker watched, whatever its plans. The plane is
/// that of the boards; place and turn in it come from where the arm was sent (fit_workplane_to_arm)
/// and are as wrong as the cell file is about the arm, until field and arm are learned. The
/// reflector on the tool stays unknown. Throws what these steps throw, and InputError without a
/// board on the plane.
PairTrackerReport pair_without_tracker(const PairTrackerRequest& request);

/// Adds a row for each pose that no tracker watched, unless the plane's fit has left it out or a
/// lamp's ray does not meet the plane.
void add_unattended(const Workplane& workplane, const WorkplaneFit& fit,
                    const std::vector<PoseSight>& poses, PairTrackerReport& report);

}  // namespace planar
