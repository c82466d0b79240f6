#pragma once

#include <filesystem>

#include "planar_servo/devices/frame_source.h"
#include "planar_servo/offline/record/recorder.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Lists what was recorded into `folder`, and how the camera's frames came.
ReportList record_list(const RecordReport& report, const FrameCounts& frames,
                       const std::filesystem::path& folder);

}  // namespace planar
