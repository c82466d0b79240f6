#pragma once

#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/frame_table.h"
#include "planar_servo/files/tables/lamp_table.h"
#include "planar_servo/health/health_record.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Keeps what a cell is like from the places of a recording in which both lamps were located.
/// Throws InputError when fewer than kHealthPlaces are left.
HealthRecord health_of_recording(const CellSettings& cell, const VisionCalibration& vision,
                                 const std::vector<FrameRow>& frames,
                                 const std::vector<LampRow>& lamps);

}  // namespace planar
