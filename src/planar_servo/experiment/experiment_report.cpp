#include "planar_servo/experiment/experiment_report.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/work/run/servo_report.h"

namespace planar {
namespace {

/// Stands for what the paper does not print and what nobody has judged.
constexpr char kNone[] = "–";

void list_accuracies(ReportList& list, const std::string& key, const std::string& head,
                     const std::vector<AccuracyRow>& rows) {
  list.rows(key, rows, [&head](ReportList& row, const AccuracyRow& found) {
    row.line(head, "{label}", found.label);
    row.line("ours: A2", "{ours:.1%}", found.ours.a2);
    row.line("ours: A1", "{ours_a1:.1%}", found.ours.a1);
    row.line("paper's chain: A2 +", "{paper_chain:.1%}", found.paper_chain.a2);
    row.line("paper's chain: A1", "{paper_chain_a1:.1%}", found.paper_chain.a1);
    row.line("paper: A2", "{paper:.1%}", found.paper);
  });
}

/// Lists a comparison whose figures are written in `unit`, those of the paper in a format and
/// behind words of their own.
void list_comparison(ReportList& list, const std::string& key, const std::string& head,
                     const std::vector<ComparisonRow>& rows, double unit, const std::string& format,
                     const std::string& paper_format, const std::string& paper = "paper") {
  list.rows(key, rows, [&](ReportList& row, const ComparisonRow& found) {
    row.line(head, "{label}", found.label);
    row.line("ours", "{ours:" + format + "}", found.ours / unit);
    row.line("paper's chain", "{paper_chain:" + format + "}", found.paper_chain / unit);
    row.line(paper, "{paper:" + paper_format + "}", found.paper / unit);
  });
}

void list_positioning(ReportList& list, const std::vector<PositioningRow>& rows) {
  list.rows("table7", rows, [](ReportList& row, const PositioningRow& found) {
    row.line("circle about", "{label}", found.label);
    row.line("before *", "{before:.3f}", mm(found.before));
    row.line("paper's chain +", "{paper_chain:.3f}", mm(found.paper_chain));
    row.line("its gain", "{paper_chain_improvement:.1%}", found.improvement(found.paper_chain));
    row.line("ours", "{ours:.4f}", mm(found.ours));
    row.line("our gain", "{ours_improvement:.1%}", found.improvement(found.ours));
    row.line("paper: before ~",
             std::isfinite(found.paper_before) ? fixed(mm(found.paper_before), 3) : kNone);
    row.line("paper: after", "{paper:.3f}", mm(found.paper_after));
    row.line("paper: gain", "{paper_improvement:.1%}", found.paper_improvement);
  });
}

/// Lists the rows of the paper's tables, which have the keys `table1` to `table7`; the last without
/// the row of all circles.
ReportList tables_list(const PaperTables& tables) {
  ReportList list;
  list_comparison(list, "table1", "circle", tables.run_correlation, 1.0, ".4f", ".3f");
  list_accuracies(list, "table2", "circle", tables.idw_accuracy);
  list_comparison(list, "table3", "what", tables.map_sources, 1.0, ".4g", ".4g");
  list_comparison(list, "table4", "circle", tables.repeatability, kMillimetre, ".6f", ".3f",
                  "paper: below");
  list_accuracies(list, "table5", "circle", tables.rbf_accuracy);
  list_accuracies(list, "table6", "method", tables.mean_accuracy);
  std::vector<PositioningRow> circles = tables.positioning;
  if (!circles.empty()) circles.pop_back();
  list_positioning(list, circles);
  return list;
}

TextTable positioning_table_of(const ExperimentReport& report) {
  ReportList list;
  list_positioning(list, report.tables.positioning);
  return list.table(
      fmt::format("Table 7: mean {} positioning error in mm, {} targets on each circle of radius "
                  "{} mm",
                  report.reflector_sigma ? "measured" : "true",
                  report.circles.front().targets.size(), report.circles.front().radius_mm),
      "table7");
}

TextTable chain_table(const ExperimentReport& report) {
  TextTable table(
      fmt::format("Chains side by side on this recording: {} errors at the targets in mm",
                  report.reflector_sigma ? "measured" : "true"),
      {"chain", "camera model", "lamp centres", "error map", "control law", "vision error: mean",
       "end point: mean", "at 95 %", "largest"});
  const auto row = [&](std::vector<std::string> fields, const std::vector<TargetResult>& results) {
    const auto after = figures_of(results).after_judged;
    const auto field = [](std::optional<double> metres) {
      return metres && std::isfinite(*metres) ? fmt::format("{:#.3g}", mm(*metres)) : kNone;
    };
    fields.push_back(field(mean_error(results, &TargetResult::vision_compensated)));
    for (const auto figure : {&Summary::mean, &Summary::p95, &Summary::max})
      fields.push_back(field(after ? std::optional((*after).*figure) : std::nullopt));
    table.add_row(std::move(fields));
  };
  row({"the paper's +", "k1", "Canny, Kåsa", "Gaussian RBF", "inverse"}, report.paper);
  row({"without its map +", "k1", "Canny, Kåsa", "none", "inverse"}, report.paper_no_map);
  row({"ViSP's", "vpCalibration", "vpDot2", "none", "vpServo"}, report.visp);
  row({"ours", "chosen", "rim", "field at the lamps", "vpServo"}, report.ours);
  return table;
}

std::vector<ShownTable> map_tables_of(const PaperTables& tables) {
  const ReportList list = tables_list(tables);
  return {
      {list.table("Table 1: correlation of the vision error between three runs", "table1"),
       "Each circle is gone round three times, and the error components of the runs are compared "
       "in pairs. Near 1, the error belongs to the place and a map can learn it. Our error before "
       "the map is smaller, so that the same noise weighs more. The numbers have no unit."},
      {list.table("Table 2: accuracy of inverse distance weighting on circles about the base",
                  "table2"),
       "The map is made of the training positions, and judged on circles that it has not seen. "
       "A2 = 1 - |mean|E| - mean|Ê|| / mean|E| is the paper's accuracy, with the measured errors E "
       "and the predicted ones Ê; A1 = 1 - mean|E - Ê| / mean|E| sees directions, too. 100 % is a "
       "perfect map. Compare with Table 5, which has the same places."},
      {list.table("Table 3: what the error maps were made of", "table3"),
       "The paper turned its width by hand; so does its chain here, by the test positions. Widths "
       "of different functions do not compare: ours may be a multiquadric on a polynomial."},
      {list.table("Table 4: standard deviation of three predictions in mm, the largest of a circle",
                  "table4"),
       "Each place of the check circles was seen in three frames, and the map predicts from "
       "each of them. The figure says how little the noise of vision moves a prediction; it does "
       "not say that a prediction is right."},
      {list.table("Table 5: accuracy of the radial basis functions on the same circles", "table5"),
       "Look at A1 beside A2: where A1 is much lower, the predicted lengths are right on average "
       "and the errors themselves are not."},
      {list.table("Table 6: accuracy, mean of the three circles", "table6"),
       "The better method is the one that leaves less of the error: A1 says so."}};
}

/// Says what a tracker judged in place of a truth, and what it cannot see.
void list_judge(ReportList& list, const ExperimentReport& report) {
  if (!report.reflector_sigma) return;
  const auto judged = [](const std::vector<TargetResult>& results) {
    return fmt::format("{} of {}", error_lengths(results, &TargetResult::after_judged).size(),
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

std::vector<ShownTable> shown_tables(const ExperimentReport& report) {
  std::vector<ShownTable> shown;
  if (!report.tables.run_correlation.empty()) shown = map_tables_of(report.tables);
  shown.push_back(
      {positioning_table_of(report),
       "All chains move to the same targets on the same cell. \"Before\" is where the arm ends by "
       "the cell file's lengths and zeros, without vision; the other columns are after feedback. A "
       "gain is the share of the error before that is gone after. Ours is aimed by the arm that "
       "was found, so its first move ends close already."});
  shown.push_back(
      {chain_table(report),
       "The vision error is vision minus truth at the last look; the end point's columns are how "
       "far it stops from its targets. ViSP brings no error map, so compare it with the paper's "
       "chain without its map: both take the plane from the laid board and differ by camera model, "
       "lamp centres and law. What no law can take off is vision's error."});
  return shown;
}

std::string marks_text(const ExperimentReport& report) {
  std::string text =
      "ours is planar-servo; the paper's chain is the paper's method on the same recording; paper "
      "is "
      "what the paper prints of its own platform\n";
  if (!report.tables.run_correlation.empty())
    text +=
        "A2, the paper's accuracy, compares mean lengths and cannot see direction: an error "
        "predicted the wrong way counts as predicted; A1 takes the length of what is left\n";
  return text +
         "* fitted on calib/paper: its arm was made to meet the paper's means before feedback, "
         "which confirm nothing there\n"
         "+ chosen on calib/paper: of 35 lens warps one was kept that brings the paper's chain "
         "near the paper's Tables 2, 5 and 7\n"
         "~ follows from the two figures beside it; the paper prints only the mean of all four\n";
}

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
  if (const auto found = figures_of(report.paper_no_map).after_judged)
    list.line("", fmt::format("positioning by the paper's chain without a map: {:.3f} mm mean",
                              mm(found->mean)));
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
