#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/offline/pairs/pair_tracker.h"

namespace planar {

/// Returns what was registered, fitted, rejected and paired, as lines for a terminal.
std::string pair_tracker_text(const PairTrackerReport& report);

/// Returns the figures of a pairing under the keys of --json.
nlohmann::json pair_tracker_json(const PairTrackerReport& report);

}  // namespace planar
