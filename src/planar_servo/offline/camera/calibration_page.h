#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Lists what a calibration found. A figure that does not exist is null.
ReportList calibration_list(const CameraCalibration& found);

/// Judges a calibration by its views, those left out of the fit, and what of the picture it has
/// seen.
Verdict camera_verdict(const CameraCalibration& found);

/// Returns the page about a camera file that was made from these pictures and tables.
std::string camera_page(const CameraCalibration& found, const std::filesystem::path& file,
                        const std::vector<std::filesystem::path>& inputs);

}  // namespace planar
