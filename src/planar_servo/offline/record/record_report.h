#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/devices/frame_source.h"
#include "planar_servo/offline/record/recorder.h"

namespace planar {

/// Returns what was recorded into `folder`, and how the camera's frames came, as lines for a
/// terminal.
std::string record_text(const RecordReport& report, const FrameCounts& frames,
                        const std::filesystem::path& folder);

/// Returns the figures of a recording under the keys of --json.
nlohmann::json record_json(const RecordReport& report, const FrameCounts& frames);

}  // namespace planar
