#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/offline/locate_lamps.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Returns true when some image shows what was looked for, even if the lamps cannot be told apart.
bool shows_any(const LocateReport& report);

/// Says how far apart the lamps of status wrong_distance are, in the median, where the cell says
/// `separation`, metres. Empty when there is no such image with one pair.
std::optional<Refusal> distance_doubt(const LocateReport& report, double separation);

/// Lists how often lamps were found, how fast and how well. What does not exist is null.
ReportList locate_list(const LocateReport& report);

/// A lamp in one of several images of a place at which the arm rested.
struct RepeatedSight {
  double at{0.0};                    ///< the row of its image, from 1
  Eigen::Vector2d off_px{0.0, 0.0};  ///< from the mean of its place, as large as one image is off
  Eigen::Vector2d pull{0.0, 0.0};    ///< the same per axis, divided by the stated deviation
};

/// Returns every lamp of the images that share an id with others. What the mean takes of the
/// scatter is given back.
std::vector<RepeatedSight> repeated_sights(const std::vector<LampRow>& rows);

/// Says whether located lamps are good, by the images without them and by the scatter at rest.
Verdict lamps_verdict(const LocateReport& report);

/// Returns the page about lamps.csv. The sensor's size is empty where it is not known.
std::string lamps_page(const LocateReport& report, const std::filesystem::path& file,
                       const std::optional<cv::Size>& sensor_px);

}  // namespace planar
