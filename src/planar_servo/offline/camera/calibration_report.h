#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/calibration/camera_calibration.h"

namespace planar {

/// Returns what a calibration found, as lines for a terminal.
std::string calibration_text(const CameraCalibration& found);

/// Returns the figures of a calibration under the keys of --json. A figure that does not exist is
/// null.
nlohmann::json calibration_json(const CameraCalibration& found);

}  // namespace planar
