#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace planar {

// `rows` are the figures of experiment_list() with their `seed`, at least one.

/// Returns the median over the cells of every key that is a number in each; `targets` and `reached`
/// are sums instead. Beside them stand the worst mean, under `median_95` the distribution-free 95 %
/// interval of every median as far as there are enough cells, and under `cells` the rows.
nlohmann::json campaign_json(const std::vector<nlohmann::json>& rows);

/// Returns the errors of one cell in words.
std::string campaign_row_text(const nlohmann::json& row);

/// Returns a row for each cell, the median with its interval and the worst.
std::string campaign_text(const std::vector<nlohmann::json>& rows);
/// Returns the text of report.html for the campaign.
std::string campaign_page(const std::vector<nlohmann::json>& rows, const std::string& cell_name);

}  // namespace planar
