#include "planar_servo/experiment/campaign_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "planar_servo/core/statistics.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/text_table.h"

namespace planar {
namespace {

constexpr double kConfidence = 0.95;

struct Column {
  const char* title;
  const char* key;  ///< a key of experiment_list(), or of its part `part`
  const char* part{nullptr};
};

constexpr Column kColumns[] = {
    {"before", "before_mean_mm_truth", "paper_chain"},
    {"paper's chain", "after_mean_mm_truth", "paper_chain"},
    {"ours", "after_mean_mm_truth"},
    {"ours, 95 %", "after_p95_mm_truth"},
    {"ours, max", "after_max_mm_truth"},
    {"predicted", "predicted_mean_mm"},
    {"predicted, 95 %", "predicted_p95_mm"},
};

double value_of(const nlohmann::json& row, const Column& column) {
  return (column.part ? row.at(column.part) : row).at(column.key).get<double>();
}

std::vector<double> values_of(const std::vector<nlohmann::json>& rows, const Column& column) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const nlohmann::json& row : rows) values.push_back(value_of(row, column));
  return values;
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

std::string four_decimals(double value) {
  return fmt::format("{:.4f}", value);
}

std::string interval_text(const std::vector<double>& values) {
  const auto interval = median_interval(values, kConfidence);
  return interval ? fmt::format("{:.4f} to {:.4f}", interval->first, interval->second) : "–";
}

TextTable campaign_table(const std::vector<nlohmann::json>& rows) {
  std::vector<std::string> header{"drawn cell"}, middle{"median"};
  std::vector<std::string> interval{"95 % interval of the median"}, worst{"worst"};
  for (const Column& column : kColumns) {
    const std::vector<double> values = values_of(rows, column);
    header.emplace_back(column.title);
    middle.push_back(four_decimals(median(values)));
    interval.push_back(interval_text(values));
    worst.push_back(four_decimals(largest(values)));
  }
  TextTable table("True positioning error in mm, mean of the control targets", header);
  for (const nlohmann::json& row : rows) {
    std::vector<std::string> fields{fmt::format("seed {}", row.at("seed").get<std::uint32_t>())};
    for (const Column& column : kColumns) fields.push_back(four_decimals(value_of(row, column)));
    table.add_row(std::move(fields));
  }
  for (auto* line : {&middle, &interval, &worst}) table.add_row(std::move(*line));
  return table;
}

bool is_sum(const std::string& key) {
  return key == "targets" || key == "reached";
}

bool is_number_in_all(const std::string& key, const std::vector<nlohmann::json>& rows) {
  return std::all_of(rows.begin(), rows.end(), [&](const nlohmann::json& row) {
    return row.contains(key) && row[key].is_number();
  });
}

}  // namespace

nlohmann::json campaign_json(const std::vector<nlohmann::json>& rows) {
  nlohmann::json json{{"seeds", rows.size()}, {"cells", rows}};
  nlohmann::json intervals = nlohmann::json::object();
  for (const auto& item : rows.front().items()) {
    const std::string& key = item.key();
    if (key == "seed" || !is_number_in_all(key, rows)) continue;
    const std::vector<double> values = values_of(rows, {"", key.c_str()});
    json[key] = is_sum(key) ? std::accumulate(values.begin(), values.end(), 0.0) : median(values);
    const auto interval = median_interval(values, kConfidence);
    if (interval && !is_sum(key)) intervals[key] = {interval->first, interval->second};
  }
  json["median_95"] = std::move(intervals);
  json["worst_after_mean_mm_truth"] = largest(values_of(rows, {"", "after_mean_mm_truth"}));
  return json;
}

std::string campaign_row_text(const nlohmann::json& row) {
  std::vector<std::string> figures;
  for (const Column& column : kColumns)
    figures.push_back(fmt::format("{} {}", column.title, four_decimals(value_of(row, column))));
  return fmt::format("{} mm", fmt::join(figures, "; "));
}

std::string campaign_text(const std::vector<nlohmann::json>& rows) {
  return campaign_table(rows).plain_text();
}

std::string campaign_page(const std::vector<nlohmann::json>& rows, const std::string& cell_name) {
  HtmlPage page(
      fmt::format("The paper's experiment on {} cells drawn like {}", rows.size(), cell_name));
  page.add_html(campaign_table(rows).html());
  return page.text();
}

}  // namespace planar
