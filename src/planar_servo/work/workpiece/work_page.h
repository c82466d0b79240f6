#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "planar_servo/report/report_list.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {

/// Lists where works were found and how well their marks fit.
ReportList work_list(const std::vector<FoundWork>& works);

/// Returns a page with the picture of each work, its marks and the drawing's axes over it, and how
/// well they fit. Pixels of `image` are those of the sensor.
std::string work_page(const std::vector<FoundWork>& works, const cv::Mat& image,
                      const std::filesystem::path& file);

}  // namespace planar
