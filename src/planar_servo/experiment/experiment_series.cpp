#include "planar_servo/experiment/experiment_series.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/experiment/experiment_report.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/text_table.h"
#include "planar_servo/virtual_cell/truth/truth_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

struct Column {
  const char* title;
  const char* key;  ///< a key of experiment_json(), or of its part `part`
  const char* part{nullptr};
};

constexpr Column kColumns[] = {
    {"before", "before_mean_mm_truth"},
    {"paper's chain", "after_mean_mm_truth", "paper_chain"},
    {"ours", "after_mean_mm_truth"},
    {"ours, 95 %", "after_p95_mm_truth"},
    {"ours, max", "after_max_mm_truth"},
    {"predicted", "predicted_mean_mm"},
    {"predicted, 95 %", "predicted_p95_mm"},
};

ExperimentReport run_drawn_cell(const ExperimentRequest& request, std::uint32_t seed) {
  ExperimentRequest drawn = request;
  drawn.seed = seed;
  drawn.out = request.out / fmt::format("seed_{}", seed);
  if (fs::exists(drawn.out))
    throw InputError(drawn.out.string() + ": exists already; name another folder");
  make_folder(drawn.out);
  const fs::path truth = drawn.out / "truth.yaml";
  write_truth(truth, draw_truth(seed));
  drawn.cell.truth = truth;
  const auto devices = open_cell(drawn.cell);
  ExperimentReport report = run_experiment(drawn, *devices);
  fs::remove_all(drawn.out / "recording");
  return report;
}

std::vector<double> values_of(const std::vector<nlohmann::json>& cells, const Column& column) {
  std::vector<double> values;
  values.reserve(cells.size());
  for (const nlohmann::json& cell : cells)
    values.push_back((column.part ? cell[column.part] : cell)[column.key].get<double>());
  return values;
}

std::vector<nlohmann::json> cells_json(const std::vector<SeriesRow>& rows) {
  std::vector<nlohmann::json> cells;
  for (const SeriesRow& row : rows) {
    cells.push_back(experiment_json(row.report));
    cells.back()["seed"] = row.seed;
  }
  return cells;
}

TextTable series_table(const std::vector<SeriesRow>& rows) {
  std::vector<std::string> header{"drawn cell"};
  for (const Column& column : kColumns) header.emplace_back(column.title);
  TextTable table("True positioning error in mm, mean of the control targets", header);
  std::vector<std::vector<std::string>> lines;
  lines.reserve(rows.size());
  for (const SeriesRow& row : rows) lines.push_back({fmt::format("seed {}", row.seed)});
  std::vector<std::string> middle{"median"}, worst{"worst"};
  const std::vector<nlohmann::json> cells = cells_json(rows);
  for (const Column& column : kColumns) {
    const std::vector<double> values = values_of(cells, column);
    for (std::size_t i = 0; i < values.size(); ++i)
      lines[i].push_back(fmt::format("{:.4f}", values[i]));
    middle.push_back(fmt::format("{:.4f}", median(values)));
    worst.push_back(fmt::format("{:.4f}", *std::max_element(values.begin(), values.end())));
  }
  for (auto& line : lines) table.add_row(std::move(line));
  table.add_row(std::move(middle));
  table.add_row(std::move(worst));
  return table;
}

}  // namespace

std::vector<SeriesRow> run_series(const ExperimentRequest& request, int count) {
  std::vector<SeriesRow> rows;
  for (int i = 0; i < count; ++i) {
    const auto seed = static_cast<std::uint32_t>(request.seed) + static_cast<std::uint32_t>(i);
    spdlog::info(fmt::format("cell {} of {}, seed {}", i + 1, count, seed));
    rows.push_back({seed, run_drawn_cell(request, seed)});
  }
  return rows;
}

nlohmann::json series_json(const std::vector<SeriesRow>& rows) {
  const std::vector<nlohmann::json> cells = cells_json(rows);
  nlohmann::json json{{"seeds", rows.size()}, {"cells", cells}};
  for (const auto& [key, value] : cells.front().items()) {
    if (!value.is_number() || key == "seed") continue;
    const std::vector<double> values = values_of(cells, {"", key.c_str()});
    double sum = 0.0;
    for (const double v : values) sum += v;
    json[key] = key == "targets" || key == "reached" ? sum : median(values);
  }
  const std::vector<double> means = values_of(cells, {"", "after_mean_mm_truth"});
  json["worst_after_mean_mm_truth"] = *std::max_element(means.begin(), means.end());
  return json;
}

std::string series_text(const std::vector<SeriesRow>& rows) {
  return series_table(rows).plain_text();
}

std::string series_page(const std::vector<SeriesRow>& rows, const std::string& cell_name) {
  HtmlPage page(
      fmt::format("The paper's experiment on {} cells drawn like {}", rows.size(), cell_name));
  page.add_html(series_table(rows).html());
  return page.text();
}

}  // namespace planar
