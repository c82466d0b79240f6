#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/trackers/stream/reading_stream.h"

namespace planar {

/// Examines a tracker whose program writes lines: whether they come, are readings, and tell lengths
/// that a tracker can measure. `feed` begins to feed a stream and throws WorkError when it cannot.
std::vector<Finding> examine_stream(
    const std::string& source, const CellSettings& cell,
    const std::function<std::unique_ptr<StreamFeed>(ReadingStream&)>& feed);

}  // namespace planar
