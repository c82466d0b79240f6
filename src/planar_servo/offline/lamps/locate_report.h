#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "planar_servo/offline/lamps/locate_lamps.h"

namespace planar {

/// How often lamps were found, and how fast.
struct LocateFigures {
  std::size_t images{0};
  std::size_t ok{0};
  std::map<std::string, std::size_t> other_statuses;  ///< how many images have each
  std::optional<double> milliseconds_median;          ///< per image
  std::optional<double> sigma_phi_median;             ///< of the tool's direction, radians

  /// True when some image shows what was looked for, even if nobody can say which lamp is which.
  bool any() const { return ok > 0 || other_statuses.count("ambiguous") > 0; }
};

LocateFigures figures_of(const LocateReport& report);

/// One line for a terminal.
std::string locate_text(const LocateFigures& figures);

/// The same figures under the keys of --json; null where a figure does not exist.
nlohmann::json locate_json(const LocateFigures& figures);

}  // namespace planar
