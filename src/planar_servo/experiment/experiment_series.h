#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/experiment/experiment.h"

namespace planar {

/// The experiment on one drawn cell.
struct SeriesRow {
  std::uint32_t seed{0};
  ExperimentReport report;
};

/// The experiment on `count` virtual cells that differ from the request's in their truth alone,
/// drawn from the seeds request.seed, request.seed + 1, ... Each has its folder `seed_N`; its
/// recording, of about a gigabyte, is removed when it has been used. Throws what run_experiment()
/// throws.
std::vector<SeriesRow> run_series(const ExperimentRequest& request, int count);

/// The keys of experiment_json() that are numbers, each the median over the cells, but for
/// `targets` and `reached`, which are sums; the worst mean; and every cell's under `cells`.
nlohmann::json series_json(const std::vector<SeriesRow>& rows);

/// A row per cell, the median and the worst.
std::string series_text(const std::vector<SeriesRow>& rows);
std::string series_page(const std::vector<SeriesRow>& rows, const std::string& cell_name);

}  // namespace planar
