#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/offline/pairs/pair_tracker.h"

namespace planar {

/// Returns what was registered, fitted, rejected and paired, as lines for a terminal.
std::string pair_tracker_text(const PairTrackerReport& report);

/// Returns the figures of a pairing under the keys of --json.
nlohmann::json pair_tracker_json(const PairTrackerReport& report);

/// Returns a doubt in words when the monuments lie farther from their known places than the
/// tracker's noise explains. Empty when there is no doubt.
std::string moved_monuments(const PairTrackerRequest& request, double datum_rms);

}  // namespace planar
