#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/offline/pairs/pair_tracker.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Lists what was registered, fitted, rejected and paired.
ReportList pair_tracker_list(const PairTrackerReport& report);

/// Says whether pairs are good, by what was left out, what the readings leave open, and their
/// scatter at rest.
Verdict pair_verdict(const PairTrackerRequest& request, const PairTrackerReport& report);

std::string pair_page(const PairTrackerRequest& request, const PairTrackerReport& report,
                      const std::filesystem::path& file);

}  // namespace planar
