#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planar_servo/offline/record/recorder.h"

namespace planar {

/// Returns the ids that the folder of a recording holds already; none when it is new. `joints` are
/// those of the plan. Throws InputError when it was begun with another plan or another cell: a row
/// of the plan was recorded for something else or elsewhere, its pulses are not those of this
/// cell's drives, its images are not of this cell's sensor, or a monument of the cell was not read.
std::set<std::string> ids_of_begun_recording(const RecordRequest& request,
                                             const std::vector<Joints>& joints);

/// Returns the readings of the cell's monuments that follow the last reading of a place in a
/// recording; nothing when no place was read.
std::optional<std::vector<MonumentSeen>> monuments_after_places(const RecordRequest& request);

}  // namespace planar
