#include "planar_servo/experiment/experiment_report.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"
#include "planar_servo/experiment/tables/table_texts.h"
#include "planar_servo/run/servo_report.h"

namespace planar {
namespace {

/// Says what a tracker judged in place of a truth, and what it cannot see.
void list_judge(ReportList& list, const ExperimentReport& report) {
  if (!report.reflector_sigma) return;
  const auto judged = [](const std::vector<TargetResult>& results) {
    return fmt::format("{} of {}", error_lengths(results, &TargetResult::after_truth).size(),
                       results.size());
  };
  list.line("", fmt::format("judged by the cell's tracker: {} targets with our chain, {} with the "
                            "paper's, {} with that without a map, {} with ViSP's",
                            judged(report.ours), judged(report.paper), judged(report.paper_no_map),
                            judged(report.visp)));
  list.line("",
            "the reflector's offset on the tool is known to {reflector_offset_sigma_mm:.4f} mm per "
            "axis by the same tracker; its error shows in no figure",
            report.reflector_sigma);
}

}  // namespace

ReportList prediction_list(const PositioningPrediction& prediction) {
  ReportList list;
  list.line("",
            "predicted without a truth: {predicted_mean_mm:.4f} mm mean, {predicted_p95_mm:.4f} at "
            "95 %",
            prediction.mean, prediction.p95);
  return list;
}

ReportList experiment_list(const ExperimentReport& report) {
  ReportList list = tables_list(report.tables);
  list.line("",
            "vision error at the control targets: {vision_raw_mean_mm:.3f} mm mean by the paper's "
            "chain without a map, {vision_after_mean_mm:.4f} mm by ours",
            mean_error(report.paper_no_map, &TargetResult::vision_raw),
            mean_error(report.ours, &TargetResult::vision_compensated));
  list.line("",
            fmt::format("positioning by the paper's chain without a map: {:.3f} mm mean",
                        mean_error(report.paper_no_map, &TargetResult::after_truth) / kMillimetre));
  list.line("", "ours:");
  list.append(servo_list(figures_of(report.ours)));
  for (const auto& [key, results] : {std::pair("paper_chain", &report.paper),
                                     {"paper_chain_no_map", &report.paper_no_map},
                                     {"visp_chain", &report.visp}})
    list.unprinted(key, servo_list(figures_of(*results)).json());
  list_judge(list, report);
  list.line("",
            "no tracker reading fixed the turn about the base's axis: the scorer turned all true "
            "places by {turn_taken_out_deg:.4f} deg to meet the targets best",
            report.turn_taken_out);
  list.append(prediction_list(report.prediction));
  return list;
}

std::string experiment_text(const ExperimentReport& report) {
  std::string text;
  for (const ShownTable& shown : shown_tables(report)) text += shown.table.plain_text() + '\n';
  return text + marks_text(report) + '\n' + experiment_list(report).text();
}

}  // namespace planar
