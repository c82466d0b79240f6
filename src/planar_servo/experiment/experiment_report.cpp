#include "planar_servo/experiment/experiment_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/experiment/paper_tables.h"
#include "planar_servo/experiment/plots/plots.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/work/run/servo_report.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

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
    row.line_if(std::isfinite(found.paper_before), "paper: before ~",
                fixed(mm(found.paper_before), 3));
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

const char* judged_how(const ExperimentReport& report) {
  return report.reflector_sigma ? "measured" : "true";
}

TextTable positioning_table_of(const ExperimentReport& report) {
  ReportList list;
  list_positioning(list, report.tables.positioning);
  list.show("table7", fmt::format("Table 7: mean {} positioning error in mm, {} targets on each "
                                  "circle of radius {} mm",
                                  judged_how(report), report.circles.front().targets.size(),
                                  report.circles.front().radius_mm));
  return list.table("table7");
}

TextTable chain_table(const ExperimentReport& report) {
  ReportList list;
  const auto add = [&list](const std::array<const char*, 5>& words,
                           const std::vector<TargetResult>& results) {
    const auto after = figures_of(results).after_judged;
    ReportList& row = list.row("chains");
    auto word = words.begin();
    for (const char* name : {"chain", "camera model", "lamp centres", "error map", "control law"})
      row.line(name, *word++);
    row.line("vision error: mean", "{vision_mm:#.3g}",
             mean_error(results, &TargetResult::vision_compensated));
    row.line("end point: mean", "{mean_mm:#.3g}", part_of(after, &Summary::mean));
    row.line("at 95 %", "{p95_mm:#.3g}", part_of(after, &Summary::p95));
    row.line("largest", "{max_mm:#.3g}", part_of(after, &Summary::max));
  };
  add({"the paper's +", "k1", "Canny, Kåsa", "Gaussian RBF", "inverse"}, report.paper);
  add({"without its map +", "k1", "Canny, Kåsa", "none", "inverse"}, report.paper_no_map);
  add({"ViSP's", "vpCalibration", "vpDot2", "none", "vpServo"}, report.visp);
  add({"ours", "chosen", "rim", "field at the lamps", "vpServo"}, report.ours);
  list.show("chains",
            fmt::format("Chains side by side on this recording: {} errors at the targets in mm",
                        judged_how(report)));
  return list.table("chains");
}

/// A table of the paper as it is shown.
struct ShownTable {
  TextTable table;
  std::string look_at;  ///< sentences that say what the table shows and what to look at
};

std::vector<ShownTable> map_tables_of(const PaperTables& tables) {
  ReportList list = tables_list(tables);
  const auto titled = [&list](const char* key, const char* title) {
    list.show(key, title);
    return list.table(key);
  };
  return {
      {titled("table1", "Table 1: correlation of the vision error between three runs"),
       "Each circle is gone round three times, and the error components of the runs are compared "
       "in pairs. Near 1, the error belongs to the place and a map can learn it. Our error before "
       "the map is smaller, so that the same noise weighs more. The numbers have no unit."},
      {titled("table2",
              "Table 2: accuracy of inverse distance weighting on circles about the base"),
       "The map is made of the training positions, and judged on circles that it has not seen. "
       "A2 = 1 - |mean|E| - mean|Ê|| / mean|E| is the paper's accuracy, with the measured errors E "
       "and the predicted ones Ê; A1 = 1 - mean|E - Ê| / mean|E| sees directions, too. 100 % is a "
       "perfect map. Compare with Table 5, which has the same places."},
      {titled("table3", "Table 3: what the error maps were made of"),
       "The paper turned its width by hand; so does its chain here, by the test positions. Widths "
       "of different functions do not compare: ours may be a multiquadric on a polynomial."},
      {titled("table4",
              "Table 4: standard deviation of three predictions in mm, the largest of a circle"),
       "Each place of the check circles was seen in three frames, and the map predicts from "
       "each of them. The figure says how little the noise of vision moves a prediction; it does "
       "not say that a prediction is right."},
      {titled("table5", "Table 5: accuracy of the radial basis functions on the same circles"),
       "Look at A1 beside A2: where A1 is much lower, the predicted lengths are right on average "
       "and the errors themselves are not."},
      {titled("table6", "Table 6: accuracy, mean of the three circles"),
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

/// Returns the tables that there are, in the paper's order.
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

/// Explains the marks and columns of the tables, a line each: what the virtual cell was fitted to,
/// and what the paper's accuracy cannot see.
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

/// Errors this many times the predicted ones put the calibration in question.
constexpr double kFarBeyondPrediction = 2.0;

/// The files that an experiment leaves in its folder, and what they hold.
constexpr std::pair<const char*, const char*> kLeftFiles[] = {
    {"figures.json", "every figure and table of this page"},
    {"errors.svg", "the picture at the top"},
    {"plan.csv", "what was recorded"},
    {"recording/frames.csv", "the recorded images"},
    {"recording/tracker.csv", "the recorded tracker readings"},
    {"ours/pairs.csv", "the end point by vision and by the tracker, our chain"},
    {"ours/run/results.csv", "the errors at the targets, our chain"},
    {"ours/run/steps.csv", "every step of the loop, our chain"},
    {"paper/pairs.csv", "the end point by vision and by the tracker, the paper's chain"},
    {"paper/run/results.csv", "the errors at the targets, the paper's chain"},
    {"paper/run/steps.csv", "every step of the loop, the paper's chain"},
    {"paper/run_without_map/results.csv", "the errors at the targets, the paper's chain unmapped"},
    {"visp/run_without_map/results.csv", "the errors at the targets, ViSP's chain"}};

std::vector<StepError> steps_of(const fs::path& run) {
  const fs::path file = run / "steps.csv";
  return fs::exists(file) ? read_step_errors(file) : std::vector<StepError>();
}

std::string judged_words(const ExperimentReport& report) {
  return report.reflector_sigma ? "errors measured by the cell's tracker" : "true errors";
}

void add_first_words(HtmlPage& page, const ExperimentReport& report) {
  const ServoFigures ours = figures_of(report.ours), paper = figures_of(report.paper);
  Verdict verdict;
  verdict.faults = run_faults(ours, "ours/run/results.csv");
  if (!ours.after_judged) {
    verdict.doubt("nobody judged where our chain ends",
                  "clear the tracker's view, and begin in another folder");
    return page.add_verdict(verdict);
  }
  if (paper.after_judged && ours.after_judged->mean >= paper.after_judged->mean)
    verdict.doubt("our chain ends no nearer than the paper's",
                  "compare the chains in Tables 3 and 5, and the errors below");
  const double ratio = ours.after_judged->mean / report.prediction.mean;
  if (ratio > kFarBeyondPrediction)
    verdict.doubt(fmt::format("the error found is {:.1f} times the predicted one", ratio),
                  "see where the errors are large below, and record training places there");
  verdict.good = fmt::format(
      "the end point stops {:.4f} mm from its targets on average, {:.4f} mm at 95 % and {:.4f} mm "
      "at worst ({} at {} targets)",
      mm(ours.after_judged->mean), mm(ours.after_judged->p95), mm(ours.after_judged->max),
      judged_words(report), ours.after_judged->n);
  page.add_verdict(verdict);
  if (!verdict.faults.empty()) page.add_paragraph("Found: " + verdict.good + ".");
}

/// Returns the errors at the targets by each way to go there, and those predicted for ours.
std::string accuracy_table(const ExperimentReport& report) {
  ReportList list;
  const auto add = [&list](const char* way, const std::optional<Summary>& found) {
    if (!found) return;
    ReportList& row = list.row("ways");
    row.line("way", way);
    row.line("mean, mm", "{mean_mm:.4f}", found->mean);
    row.line("at 95 %, mm", "{p95_mm:.4f}", found->p95);
    row.line("largest, mm", "{max_mm:.4f}", found->max);
  };
  const ServoFigures ours = figures_of(report.ours), paper = figures_of(report.paper);
  add("arm by the cell file, without calibration", paper.before_judged);
  add("the paper's chain", paper.after_judged);
  add("planar-servo, arm alone", ours.before_judged);
  add("planar-servo, with vision", ours.after_judged);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  add("planar-servo, as its calibration predicts it",
      Summary{0, report.prediction.mean, kUnknown, report.prediction.p95, kUnknown});
  list.show("ways", fmt::format("Distance from the targets: {}", judged_words(report)));
  return list.table_html("ways");
}

/// Compares what was reached with what was there before, with the paper's chain and with what was
/// predicted.
std::string worth_words(const ExperimentReport& report) {
  const auto ours = figures_of(report.ours).after_judged;
  const ServoFigures paper = figures_of(report.paper);
  if (!ours || !paper.after_judged || !paper.before_judged) return "";
  return fmt::format(
      "planar-servo removes {} % of the error that the arm has by its cell file, the paper's chain "
      "{} %; the paper's chain stops {:.1f} times as far from the targets. The calibration alone "
      "predicted {:.4f} mm; what was found is {:.2f} times that. On its own platform the paper "
      "reached {:.3f} mm.",
      fixed(100.0 * (1.0 - ours->mean / paper.before_judged->mean), 1),
      fixed(100.0 * (1.0 - paper.after_judged->mean / paper.before_judged->mean), 1),
      paper.after_judged->mean / ours->mean, mm(report.prediction.mean),
      ours->mean / report.prediction.mean, kPaperAfterMean_mm);
}

/// Returns the targets that our chain ended farthest from.
std::string worst_table(const ExperimentReport& report) {
  constexpr std::size_t kMostShown = 5;
  std::vector<TargetResult> worst;
  for (const TargetResult& result : report.ours)
    if (result.after_judged) worst.push_back(result);
  std::stable_sort(worst.begin(), worst.end(), [](const TargetResult& a, const TargetResult& b) {
    return a.after_judged->norm() > b.after_judged->norm();
  });
  ReportList list;
  for (std::size_t i = 0; i < std::min(worst.size(), kMostShown); ++i)
    list.row("worst", result_columns(worst[i]),
             {{"target"},
              {"x_mm", 1},
              {"y_mm", 1},
              {"after_" + figures_of(report.ours).judge() + "_mm", 4},
              {"uncertainty_mm", 4}});
  list.show("worst", "The targets with the largest errors");
  return list.table_html("worst");
}

std::string coverage_words(const ExperimentReport& report) {
  const ServoFigures ours = figures_of(report.ours);
  std::string words = fmt::format("{} of {} targets were reached, {} were judged.", ours.reached,
                                  ours.targets, ours.after_judged ? ours.after_judged->n : 0);
  if (ours.coverage_95)
    words += fmt::format(
        " Of the end point's estimates, {} % of the components are within their "
        "stated 95 % interval: less than 95 % means that stated uncertainties are too small, more "
        "that they are too large.",
        fixed(100.0 * ours.coverage_95->share(), 1));
  return words;
}

void add_plot(HtmlPage& page, const ReportPlot& plot, const fs::path& out) {
  const std::string file = "figures/" + plot.file;
  const std::string link =
      fs::exists(out / file) ? fmt::format(" <a href=\"{0}\">{0}</a>", file) : "";
  page.add_html(fmt::format("<figure{}>\n<figcaption><b>{}.</b> {}{}</figcaption>\n{}</figure>\n",
                            plot.panels.size() > 1 ? " class=\"broad\"" : "",
                            html_escaped(plot.title), html_escaped(plot.caption), link,
                            plot_html(plot.panels)));
}

void add_plots(HtmlPage& page, const std::vector<ReportPlot>& plots, const fs::path& out) {
  page.add_html("<div class=\"figures\">\n");
  for (const ReportPlot& plot : plots) add_plot(page, plot, out);
  page.add_html("</div>\n");
}

void add_files(HtmlPage& page, const fs::path& out) {
  std::string rows;
  for (const auto& [file, what] : kLeftFiles)
    if (fs::exists(out / file))
      rows += fmt::format("<li><a href=\"{0}\">{0}</a>: {1}</li>\n", file, what);
  if (rows.empty()) return;
  page.add_heading("Files");
  page.add_html("<ul>\n" + rows + "</ul>\n");
}

/// Returns the errors of those ways that somebody judged.
std::vector<QuiverPanel> error_panels(const ExperimentReport& report) {
  std::vector<QuiverPanel> panels;
  for (const auto& [what, results, error] :
       {std::tuple("Open loop", &report.paper, &TargetResult::before_judged),
        {"Paper's chain", &report.paper, &TargetResult::after_judged},
        {"planar-servo", &report.ours, &TargetResult::after_judged}})
    if (QuiverPanel panel = error_panel(what, *results, error); !panel.points.empty())
      panels.push_back(std::move(panel));
  return panels;
}

/// The plots of the report by the part of the page that has them.
struct ReportPlots {
  std::vector<ReportPlot> worth, coverage;
  std::vector<ReportPlot> paper;  ///< the figures of the paper that the data allow, in its order
};

/// Reads the steps of the loops from the runs in `out`.
ReportPlots experiment_plots(const ExperimentReport& report, const fs::path& out) {
  ReportPlots plots;
  const auto add = [](std::vector<ReportPlot>& to, std::vector<ReportPlot> more) {
    for (ReportPlot& plot : more) to.push_back(std::move(plot));
  };
  add(plots.worth, spread_plot(report));
  add(plots.worth,
      convergence_plot(steps_of(out / "ours" / "run"), steps_of(out / "paper" / "run")));
  add(plots.coverage, coverage_plot(report));
  if (report.recorded) add(plots.paper, paper_plots(*report.recorded));
  add(plots.paper, control_plots(report));
  return plots;
}

/// Adds the answers to an engineer's first questions.
void add_results(HtmlPage& page, const ExperimentReport& report, const ReportPlots& plots,
                 const fs::path& out) {
  page.add_heading("Accuracy");
  page.add_html(accuracy_table(report));
  const std::vector<QuiverPanel> errors = error_panels(report);
  if (!errors.empty()) page.add_html(plot_html(quiver_panels(errors)));
  page.add_paragraph(
      fmt::format("{} All chains were calibrated from the same recording. {}",
                  report.reflector_sigma
                      ? "Errors of the end point at the control targets, as the cell's tracker "
                        "measured them after the servo had ended."
                      : "True errors of the end point at the control targets, by the scorer of the "
                        "virtual cell, which alone sees the truth.",
                  kQuiverCaption));
  page.add_heading("Improvement");
  page.add_paragraph(worth_words(report));
  add_plots(page, plots.worth, out);
  if (figures_of(report.ours).after_judged)
    page.add_section("Largest errors",
                     worst_table(report) + plot_html(quiver_panels({errors.back()})),
                     "Uncertainty: the standard one per axis that our chain states. The errors "
                     "are drawn once more, at scales of their own.");
  page.add_heading("Coverage");
  page.add_paragraph(coverage_words(report));
  add_plots(page, plots.coverage, out);
  page.add_heading("The runs in numbers");
  page.add_paragraph(experiment_list(report).text());
}

void add_paper_tables(HtmlPage& page, const ExperimentReport& report) {
  page.add_heading("The paper's tables");
  page.add_paragraph(marks_text(report));
  for (const ShownTable& shown : shown_tables(report)) {
    const std::string heading = page.add_heading(shown.table.title(), 3);
    page.add_html(shown.table.html(heading));
    page.add_paragraph(shown.look_at);
  }
}

/// Returns the text of the page. It links to those files in `out` that exist.
std::string experiment_page(const ExperimentReport& report, const std::string& cell_name,
                            const ReportPlots& plots, const fs::path& out) {
  HtmlPage page("The paper's experiment on " + cell_name);
  add_first_words(page, report);
  page.add_contents();
  add_results(page, report, plots, out);
  add_paper_tables(page, report);
  page.add_heading("The paper's figures");
  page.add_paragraph(
      "The numbers are the paper's. Its Figures 1 to 5, 12 and 17 are drawings and photographs "
      "without data.");
  add_plots(page, plots.paper, out);
  add_files(page, out);
  return page.text();
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

fs::path write_experiment_report(const ExperimentReport& report, const std::string& cell_name,
                                 const fs::path& out) {
  const ReportPlots plots = experiment_plots(report, out);
  make_folder(out / "figures");
  for (const auto* part : {&plots.worth, &plots.coverage, &plots.paper})
    for (const ReportPlot& plot : *part)
      write_file(out / "figures" / plot.file, format_comment("figure") + plot_svg(plot.panels));
  if (const std::vector<QuiverPanel> errors = error_panels(report); !errors.empty())
    write_file(out / "errors.svg", format_comment("figure") + plot_svg(quiver_panels(errors)));
  write_file(out / "figures.json",
             with_format_key("figures", experiment_list(report).json().dump(2)));
  fs::path page = out / "report.html";
  write_file(page, experiment_page(report, cell_name, plots, out));
  return page;
}

}  // namespace planar
