#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/calibration/camera_calibration.h"

namespace planar {

/// What a calibration found, as lines for a terminal.
std::string calibration_text(const CameraCalibration& found);

/// The same figures under the keys of --json; null where a figure does not exist.
nlohmann::json calibration_json(const CameraCalibration& found);

}  // namespace planar
