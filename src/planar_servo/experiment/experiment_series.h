#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/experiment/experiment.h"

namespace planar {

/// Holds the experiment on one drawn cell.
struct SeriesRow {
  std::uint32_t seed{0};
  ExperimentReport report;
};

/// Runs the experiment on `count` virtual cells that differ from the request's in their truth
/// alone. The truths are drawn from the seeds request.seed, request.seed + 1, ... Each cell has its
/// folder `seed_N`; its recording of about a gigabyte is removed after use. Throws what
/// run_experiment() throws.
std::vector<SeriesRow> run_series(const ExperimentRequest& request, int count);

/// Returns the median over the cells of every key of experiment_json() that is a number; `targets`
/// and `reached` are sums instead. The worst mean stands beside them, and the figures of each cell
/// under `cells`.
nlohmann::json series_json(const std::vector<SeriesRow>& rows);

/// Returns a row for each cell, the median and the worst.
std::string series_text(const std::vector<SeriesRow>& rows);
/// Returns the text of report.html for the series.
std::string series_page(const std::vector<SeriesRow>& rows, const std::string& cell_name);

}  // namespace planar
