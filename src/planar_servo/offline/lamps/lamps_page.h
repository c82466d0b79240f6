#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "planar_servo/offline/lamps/locate_report.h"
#include "planar_servo/report/html_page.h"

namespace planar {

/// Judges located lamps by the images without them and by the scatter at rest.
Verdict lamps_verdict(const LocateReport& report);

/// Returns the page about lamps.csv. The sensor's size is empty where it is not known.
std::string lamps_page(const LocateReport& report, const std::filesystem::path& file,
                       const std::optional<cv::Size>& sensor_px);

}  // namespace planar
