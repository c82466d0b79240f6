#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include "planar_servo/offline/lamps/locate_lamps.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Says how often lamps were found, and how fast.
struct LocateFigures {
  std::size_t images{0};
  std::size_t ok{0};
  std::map<std::string, std::size_t> other_statuses;  ///< number of images with each, by its word
  std::optional<double> milliseconds_median;          ///< median time per image
  std::optional<double> sigma_phi_median;  ///< standard deviation of the tool's direction, radians

  /// Returns true when some image shows what was looked for, even if nobody can say which lamp is
  /// which.
  bool any() const { return ok > 0 || other_statuses.count(name(LampStatus::kAmbiguous)) > 0; }
};

/// Counts the statuses and takes the medians.
LocateFigures figures_of(const LocateReport& report);

/// Says how far apart the lamps of status wrong_distance are, in the median, where the cell says
/// `separation`, metres. Empty when there is no such image with one pair.
std::string distance_doubt(const LocateReport& report, double separation);

/// Lists the figures. Those that do not exist are null.
ReportList locate_list(const LocateFigures& figures);

}  // namespace planar
