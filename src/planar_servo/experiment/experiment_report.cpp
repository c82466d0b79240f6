#include "planar_servo/experiment/experiment_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/experiment/experiment_plan.h"
#include "planar_servo/experiment/paper_figures.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/quiver_figure.h"
#include "planar_servo/report/text_table.h"
#include "planar_servo/run/servo_report.h"

namespace planar {
namespace {

constexpr double kNanometre = 1e-3 * kMicrometre;

double mean_mm(const std::vector<TargetResult>& results, TargetError error) {
  return mean_error(results, error) / kMillimetre;
}

TextTable fraction_table(const std::string& title, const std::vector<ComparisonRow>& rows) {
  TextTable table(title, {"", "ours", "the paper's chain here", "the paper"});
  for (const ComparisonRow& row : rows)
    table.add_row({row.label, fmt::format("{:.1f} %", 100.0 * row.ours),
                   fmt::format("{:.1f} %", 100.0 * row.paper_chain),
                   fmt::format("{:.1f} %", 100.0 * row.paper)});
  return table;
}

TextTable correlation_table(const ExperimentReport& report) {
  TextTable table("Table 1: correlation of the vision error between three runs",
                  {"", "ours", "the paper's chain here", "the paper"});
  for (const ComparisonRow& row : report.tables.run_correlation)
    table.add_row({row.label, fmt::format("{:.4f}", row.ours),
                   fmt::format("{:.4f}", row.paper_chain), fmt::format("{:.3f}", row.paper)});
  return table;
}

/// Nobody has judged any target of a circle.
constexpr char kNobodyJudged[] = "–";

std::string judged_mm(double mean, int decimals) {
  return std::isfinite(mean) ? fmt::format("{:.{}f}", mean, decimals) : kNobodyJudged;
}

TextTable control_table(const ExperimentReport& report) {
  TextTable table(
      fmt::format("Table 7: mean {} positioning error in mm, {} targets on each circle of radius "
                  "{} mm",
                  report.reflector_sigma ? "measured" : "true",
                  report.circles.front().targets.size(), report.circles.front().radius_mm),
      {"circle about", "before", "paper's chain", "ours", "ours, improved by", "paper: before",
       "paper: after"});
  const auto row = [&](const std::string& label, double before, double paper_chain, double ours,
                       double paper_before, double paper_after) {
    table.add_row({label, judged_mm(before, 3), judged_mm(paper_chain, 3), judged_mm(ours, 4),
                   std::isfinite(ours / before) ? fixed(100.0 * (1.0 - ours / before), 1) + " %"
                                                : kNobodyJudged,
                   fmt::format("{:.3f}", paper_before), fmt::format("{:.3f}", paper_after)});
  };
  for (std::size_t i = 0; i < report.tables.positioning.size(); ++i) {
    const ComparisonRow& circle = report.tables.positioning[i];
    row(circle.label,
        mean_mm(results_on(report.circles[i], report.paper), &TargetResult::before_truth),
        circle.paper_chain / kMillimetre, circle.ours / kMillimetre, kPaperBefore_mm[i],
        circle.paper / kMillimetre);
  }
  row("all four", mean_mm(report.paper, &TargetResult::before_truth),
      mean_mm(report.paper, &TargetResult::after_truth),
      mean_mm(report.ours, &TargetResult::after_truth), kPaperBeforeMean_mm, kPaperAfterMean_mm);
  return table;
}

/// Makes a table of figures in a unit, with four digits each. What the paper does not print is left
/// out.
TextTable number_table(const std::string& title, const std::vector<ComparisonRow>& rows,
                       double unit) {
  TextTable table(title, {"", "ours", "the paper's chain here", "the paper"});
  const auto cell = [&](double value) {
    return std::isfinite(value) ? fmt::format("{:.4g}", value / unit) : "–";
  };
  for (const ComparisonRow& row : rows)
    table.add_row({row.label, cell(row.ours), cell(row.paper_chain), cell(row.paper)});
  return table;
}

std::vector<TextTable> accuracy_tables(const ExperimentReport& report) {
  if (report.tables.run_correlation.empty()) return {};
  return {
      correlation_table(report),
      fraction_table("Table 2: accuracy of inverse distance weighting on circles about the base",
                     report.tables.idw_accuracy),
      number_table("Table 3: what the error maps were made of", report.tables.map_sources, 1.0),
      number_table(
          "Table 4: standard deviation of three predictions in nm, the largest of the circle's "
          "points (the paper: less than)",
          report.tables.repeatability, kNanometre),
      fraction_table("Table 5: accuracy of the radial basis functions on the same circles",
                     report.tables.rbf_accuracy),
      fraction_table("Table 6: accuracy, mean of the three circles", report.tables.mean_accuracy)};
}

nlohmann::json rows_json(const std::vector<ComparisonRow>& rows, double unit) {
  nlohmann::json json = nlohmann::json::array();
  for (const ComparisonRow& row : rows)
    json.push_back({{"label", row.label},
                    {"ours", row.ours / unit},
                    {"paper_chain", row.paper_chain / unit},
                    {"paper", row.paper / unit}});
  return json;
}

/// Says what the scorer has done where nothing had fixed the turn.
std::string turn_text(const ExperimentReport& report) {
  if (!report.turn_taken_out) return "";
  return fmt::format(
      "no tracker reading fixed the turn about the base's axis: the scorer turned all true places "
      "by {:.4f} deg to meet the targets best\n",
      *report.turn_taken_out / kDegree);
}

/// Says what a tracker judged in place of a truth, and what it cannot see.
std::string judge_text(const ExperimentReport& report) {
  if (!report.reflector_sigma) return "";
  const auto judged = [](const std::vector<TargetResult>& results) {
    return fmt::format("{} of {}", error_lengths(results, &TargetResult::after_truth).size(),
                       results.size());
  };
  return fmt::format(
      "judged by the cell's tracker: {} targets with our chain, {} with the paper's, {} with that "
      "without a map\n"
      "the reflector's offset on the tool is known to {:.4f} mm per axis by the same tracker; its "
      "error shows in no figure\n",
      judged(report.ours), judged(report.paper), judged(report.paper_no_map),
      *report.reflector_sigma / kMillimetre);
}

/// Says what the tables do not say.
std::string summary_text(const ExperimentReport& report) {
  return fmt::format(
      "vision error at the control targets: {:.3f} mm mean by the paper's chain without a map, "
      "{:.4f} mm by ours\n"
      "positioning by the paper's chain without a map: {:.3f} mm mean\n"
      "ours: {}",
      mean_mm(report.paper_no_map, &TargetResult::vision_raw),
      mean_mm(report.ours, &TargetResult::vision_compensated),
      mean_mm(report.paper_no_map, &TargetResult::after_truth),
      servo_text(figures_of(report.ours)) + judge_text(report) + turn_text(report) +
          prediction_text(report.prediction));
}

}  // namespace

nlohmann::json experiment_json(const ExperimentReport& report) {
  nlohmann::json json = servo_json(figures_of(report.ours));
  json["vision_raw_mean_mm"] = mean_mm(report.paper_no_map, &TargetResult::vision_raw);
  json["vision_after_mean_mm"] = mean_mm(report.ours, &TargetResult::vision_compensated);
  json["paper_chain"] = servo_json(figures_of(report.paper));
  json["paper_chain_no_map"] = servo_json(figures_of(report.paper_no_map));
  const PaperTables& tables = report.tables;
  json["table1"] = rows_json(tables.run_correlation, 1.0);
  json["table2"] = rows_json(tables.idw_accuracy, 1.0);
  json["table3"] = rows_json(tables.map_sources, 1.0);
  json["table4"] = rows_json(tables.repeatability, kMillimetre);
  json["table5"] = rows_json(tables.rbf_accuracy, 1.0);
  json["table6"] = rows_json(tables.mean_accuracy, 1.0);
  json["table7"] = rows_json(tables.positioning, kMillimetre);
  if (report.turn_taken_out) json["turn_taken_out_deg"] = *report.turn_taken_out / kDegree;
  if (report.reflector_sigma)
    json["reflector_offset_sigma_mm"] = *report.reflector_sigma / kMillimetre;
  json.update(prediction_json(report.prediction));
  return json;
}

nlohmann::json prediction_json(const PositioningPrediction& prediction) {
  return {{"predicted_mean_mm", prediction.mean / kMillimetre},
          {"predicted_p95_mm", prediction.p95 / kMillimetre}};
}

std::string prediction_text(const PositioningPrediction& prediction) {
  return fmt::format("predicted without a truth: {:.4f} mm mean, {:.4f} at 95 %\n",
                     prediction.mean / kMillimetre, prediction.p95 / kMillimetre);
}

std::string experiment_text(const ExperimentReport& report) {
  std::string text;
  for (const TextTable& table : accuracy_tables(report)) text += table.plain_text() + '\n';
  return text + control_table(report).plain_text() + '\n' + summary_text(report);
}

std::string experiment_figure(const ExperimentReport& report) {
  return quiver_svg({error_panel("Open loop", report.paper, &TargetResult::before_truth),
                     error_panel("Paper's chain", report.paper, &TargetResult::after_truth),
                     error_panel("planar-servo", report.ours, &TargetResult::after_truth)});
}

std::string experiment_page(const ExperimentReport& report, const std::string& cell_name) {
  HtmlPage page("The paper's experiment on " + cell_name);
  page.add_paragraph(std::string("Mean error of the end point at the control targets, by ") +
                     (report.reflector_sigma
                          ? "the cell's tracker, as it measured after the servo had ended. "
                          : "the scorer of the virtual cell, which sees the truth. ") +
                     "Both chains were calibrated from the same recording and saw nothing else.");
  page.add_html(experiment_figure(report));
  page.add_paragraph(kQuiverCaption);
  page.add_html(quiver_svg({error_panel("planar-servo", report.ours, &TargetResult::after_truth)}));
  page.add_paragraph("The last panel once more, at scales of its own.");
  page.add_html(control_table(report).html());
  page.add_paragraph(summary_text(report));
  for (const TextTable& table : accuracy_tables(report)) page.add_html(table.html());
  return page.text();
}

}  // namespace planar
