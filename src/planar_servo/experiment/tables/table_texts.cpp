#include "planar_servo/experiment/tables/table_texts.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/run/servo_figures.h"

namespace planar {
namespace {

/// Stands for what the paper does not print and what nobody has judged.
constexpr char kNone[] = "–";

std::string percent(double fraction) {
  return std::isfinite(fraction) ? fixed(100.0 * fraction, 1) + " %" : kNone;
}

std::string millimetres(double metres, int decimals) {
  return std::isfinite(metres) ? fixed(metres / kMillimetre, decimals) : kNone;
}

TextTable accuracy_table(const std::string& title, const std::vector<AccuracyRow>& rows) {
  TextTable table(title, {"", "ours: A2", "A1", "the paper's chain here: A2 +", "A1", "the paper"});
  for (const AccuracyRow& row : rows)
    table.add_row({row.label, percent(row.ours.a2), percent(row.ours.a1),
                   percent(row.paper_chain.a2), percent(row.paper_chain.a1), percent(row.paper)});
  return table;
}

TextTable correlation_table(const std::vector<ComparisonRow>& rows) {
  TextTable table("Table 1: correlation of the vision error between three runs",
                  {"", "ours", "the paper's chain here", "the paper"});
  for (const ComparisonRow& row : rows)
    table.add_row({row.label, fmt::format("{:.4f}", row.ours),
                   fmt::format("{:.4f}", row.paper_chain), fmt::format("{:.3f}", row.paper)});
  return table;
}

TextTable source_table(const std::vector<ComparisonRow>& rows) {
  TextTable table("Table 3: what the error maps were made of",
                  {"", "ours", "the paper's chain here", "the paper"});
  const auto cell = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.4g}", value) : kNone;
  };
  for (const ComparisonRow& row : rows)
    table.add_row({row.label, cell(row.ours), cell(row.paper_chain), cell(row.paper)});
  return table;
}

TextTable repeatability_table(const std::vector<ComparisonRow>& rows) {
  TextTable table("Table 4: standard deviation of three predictions in mm, the largest of a circle",
                  {"", "ours", "the paper's chain here", "the paper: below"});
  for (const ComparisonRow& row : rows)
    table.add_row({row.label, millimetres(row.ours, 6), millimetres(row.paper_chain, 6),
                   millimetres(row.paper, 3)});
  return table;
}

TextTable positioning_table_of(const ExperimentReport& report) {
  TextTable table(
      fmt::format("Table 7: mean {} positioning error in mm, {} targets on each circle of radius "
                  "{} mm",
                  report.reflector_sigma ? "measured" : "true",
                  report.circles.front().targets.size(), report.circles.front().radius_mm),
      {"circle about", "before *", "paper's chain +", "improved", "ours", "improved",
       "paper: before ~", "after", "improved"});
  for (const PositioningRow& row : report.tables.positioning)
    table.add_row({row.label, millimetres(row.before, 3), millimetres(row.paper_chain, 3),
                   percent(row.improvement(row.paper_chain)), millimetres(row.ours, 4),
                   percent(row.improvement(row.ours)), millimetres(row.paper_before, 3),
                   millimetres(row.paper_after, 3), percent(row.paper_improvement)});
  return table;
}

TextTable chain_table(const ExperimentReport& report) {
  TextTable table(
      fmt::format("Chains side by side on this recording: {} errors at the targets in mm",
                  report.reflector_sigma ? "measured" : "true"),
      {"chain", "camera", "lamps", "error map", "law", "vision, mean", "after, mean", "95 %",
       "largest"});
  const auto row = [&](std::vector<std::string> cells, const std::vector<TargetResult>& results) {
    const auto after = figures_of(results).after_truth;
    const auto cell = [](std::optional<double> metres) {
      return metres && std::isfinite(*metres) ? fmt::format("{:#.3g}", *metres / kMillimetre)
                                              : kNone;
    };
    cells.push_back(cell(mean_error(results, &TargetResult::vision_compensated)));
    for (const auto figure : {&Summary::mean, &Summary::p95, &Summary::max})
      cells.push_back(cell(after ? std::optional((*after).*figure) : std::nullopt));
    table.add_row(std::move(cells));
  };
  row({"the paper's +", "k1", "Canny, Kasa", "Gaussian RBF", "inverse"}, report.paper);
  row({"without its map +", "k1", "Canny, Kasa", "none", "inverse"}, report.paper_no_map);
  row({"ViSP's", "vpCalibration", "vpDot2", "none", "vpServo"}, report.visp);
  row({"ours", "chosen", "rim", "field at the lamps", "vpServo"}, report.ours);
  return table;
}

std::vector<ShownTable> map_tables_of(const PaperTables& tables) {
  return {
      {correlation_table(tables.run_correlation),
       "Each circle is gone round three times, and the error components of the runs are compared "
       "in pairs. Near 1, the error belongs to the place and a map can learn it. Our error before "
       "the map is smaller, so that the same noise weighs more."},
      {accuracy_table("Table 2: accuracy of inverse distance weighting on circles about the base",
                      tables.idw_accuracy),
       "The map is made of the training positions, and judged on circles that it has not seen. "
       "Compare with Table 5, which has the same places."},
      {source_table(tables.map_sources),
       "The paper turned its width by hand; so does its chain here, by the test positions. Widths "
       "of different functions do not compare: ours may be a multiquadric on a polynomial."},
      {repeatability_table(tables.repeatability),
       "Each place of the check circles was looked at in three frames, and the map predicts from "
       "each of them. The figure says how little the noise of vision moves a prediction; it does "
       "not say that a prediction is right."},
      {accuracy_table("Table 5: accuracy of the radial basis functions on the same circles",
                      tables.rbf_accuracy),
       "Look at A1 beside A2: where A1 is much lower, the predicted lengths are right in the mean "
       "and the errors themselves are not."},
      {accuracy_table("Table 6: accuracy, mean of the three circles", tables.mean_accuracy),
       "The better method is the one that leaves less of the error: A1 says so."}};
}

}  // namespace

std::vector<ShownTable> shown_tables(const ExperimentReport& report) {
  std::vector<ShownTable> shown;
  if (!report.tables.run_correlation.empty()) shown = map_tables_of(report.tables);
  shown.push_back(
      {positioning_table_of(report),
       "All chains move to the same targets on the same cell. \"Before\" is where the arm ends "
       "by the cell file's lengths and zeros, without vision. Ours is aimed by the arm that was "
       "found, so its first move ends close already."});
  shown.push_back(
      {chain_table(report),
       "ViSP brings no error map, so compare it with the paper's chain without its map: both take "
       "the plane from the laid board and differ by camera model, lamp centres and law. What no "
       "law can take off is vision's error."});
  return shown;
}

std::string marks_text(const ExperimentReport& report) {
  std::string text;
  if (!report.tables.run_correlation.empty())
    text +=
        "A2, the paper's accuracy, compares mean lengths and cannot see direction: an error "
        "predicted the wrong way counts as predicted; A1 takes the length of what is left\n";
  return text +
         "* fitted on calib/paper: its arm was made to meet the paper's means before feedback, "
         "which confirm nothing there\n"
         "+ chosen on calib/paper: of 35 lens warps one was kept that brings the paper's chain "
         "near "
         "the paper's Tables 2, 5 and 7\n"
         "~ follows from the two figures beside it; the paper prints only the mean of all four\n";
}

}  // namespace planar
