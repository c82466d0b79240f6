#include "planar_servo/experiment/experiment_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "planar_servo/core/units.h"
#include "planar_servo/experiment/tables/table_texts.h"
#include "planar_servo/run/servo_report.h"

namespace planar {
namespace {

double mean_mm(const std::vector<TargetResult>& results, TargetError error) {
  return mean_error(results, error) / kMillimetre;
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

nlohmann::json rows_json(const std::vector<AccuracyRow>& rows) {
  nlohmann::json json = nlohmann::json::array();
  for (const AccuracyRow& row : rows)
    json.push_back({{"label", row.label},
                    {"ours", row.ours.a2},
                    {"ours_a1", row.ours.a1},
                    {"paper_chain", row.paper_chain.a2},
                    {"paper_chain_a1", row.paper_chain.a1},
                    {"paper", row.paper}});
  return json;
}

/// Lists the control circles without the row of all of them.
nlohmann::json rows_json(const std::vector<PositioningRow>& rows) {
  nlohmann::json json = nlohmann::json::array();
  for (auto row = rows.begin(); row + 1 < rows.end(); ++row)
    json.push_back({{"label", row->label},
                    {"before", row->before / kMillimetre},
                    {"ours", row->ours / kMillimetre},
                    {"ours_improvement", row->improvement(row->ours)},
                    {"paper_chain", row->paper_chain / kMillimetre},
                    {"paper_chain_improvement", row->improvement(row->paper_chain)},
                    {"paper", row->paper_after / kMillimetre},
                    {"paper_improvement", row->paper_improvement}});
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
      "without a map, {} with ViSP's\n"
      "the reflector's offset on the tool is known to {:.4f} mm per axis by the same tracker; its "
      "error shows in no figure\n",
      judged(report.ours), judged(report.paper), judged(report.paper_no_map), judged(report.visp),
      *report.reflector_sigma / kMillimetre);
}

}  // namespace

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

nlohmann::json experiment_json(const ExperimentReport& report) {
  nlohmann::json json = servo_json(figures_of(report.ours));
  json["vision_raw_mean_mm"] = mean_mm(report.paper_no_map, &TargetResult::vision_raw);
  json["vision_after_mean_mm"] = mean_mm(report.ours, &TargetResult::vision_compensated);
  json["paper_chain"] = servo_json(figures_of(report.paper));
  json["paper_chain_no_map"] = servo_json(figures_of(report.paper_no_map));
  json["visp_chain"] = servo_json(figures_of(report.visp));
  const PaperTables& tables = report.tables;
  json["table1"] = rows_json(tables.run_correlation, 1.0);
  json["table2"] = rows_json(tables.idw_accuracy);
  json["table3"] = rows_json(tables.map_sources, 1.0);
  json["table4"] = rows_json(tables.repeatability, kMillimetre);
  json["table5"] = rows_json(tables.rbf_accuracy);
  json["table6"] = rows_json(tables.mean_accuracy);
  json["table7"] = rows_json(tables.positioning);
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
  for (const ShownTable& shown : shown_tables(report)) text += shown.table.plain_text() + '\n';
  return text + marks_text(report) + '\n' + summary_text(report);
}

}  // namespace planar
