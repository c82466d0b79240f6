#include "planar_servo/experiment/experiment_report.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"
#include "planar_servo/experiment/paper_tables.h"
#include "planar_servo/experiment/plots/plots.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/run/servo_report.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Found errors of so many times the predicted ones put the calibration in question.
constexpr double kFarBeyondPrediction = 2.0;

/// The files that an experiment leaves in its folder, and what they hold.
struct LeftFile {
  const char* file;
  const char* what;
};
constexpr LeftFile kLeftFiles[] = {
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

/// Says what was found beside what was predicted; a clause without a full stop.
std::string found_and_predicted(const ServoFigures& ours, const ServoFigures& paper,
                                const PositioningPrediction& prediction) {
  return fmt::format(
      "{}; {:.4f} mm at 95 %, where the calibration alone had predicted {:.4f} and {:.4f} mm; the "
      "paper's chain on the same cell ends at {:.3f} mm, in the paper at {:.3f} mm",
      landing_words(ours), mm(ours.after_truth->p95), mm(prediction.mean), mm(prediction.p95),
      mm(paper.after_truth->mean), kPaperAfterMean_mm);
}

void add_first_words(HtmlPage& page, const ExperimentReport& report) {
  const ServoFigures ours = figures_of(report.ours), paper = figures_of(report.paper);
  Verdict verdict;
  verdict.faults = run_faults(ours, "ours/run/results.csv");
  if (!ours.after_truth || !paper.after_truth) return page.add_verdict(verdict);
  if (ours.after_truth->mean >= paper.after_truth->mean)
    verdict.faults.push_back({"our chain ends no nearer than the paper's",
                              "compare the chains in Tables 3 and 5, and the errors below"});
  const double ratio = ours.after_truth->mean / report.prediction.mean;
  if (ratio > kFarBeyondPrediction)
    verdict.faults.push_back(
        {fmt::format("the error found is {:.1f} times the predicted one", ratio),
         "look where the errors are large below, and record training places there"});
  verdict.good = found_and_predicted(ours, paper, report.prediction);
  page.add_verdict(verdict);
  if (!verdict.faults.empty()) page.add_paragraph("Found: " + verdict.good + ".");
}

void add_plot(HtmlPage& page, const ReportPlot& plot, const fs::path& out) {
  const std::string file = "figures/" + plot.file;
  const std::string link =
      fs::exists(out / file) ? fmt::format(" <a href=\"{0}\">{0}</a>", file) : "";
  page.add_html(fmt::format("<figure>\n<figcaption><b>{}.</b> {}{}</figcaption>\n{}</figure>\n",
                            html_escaped(plot.title), html_escaped(plot.caption), link, plot.svg));
}

void add_files(HtmlPage& page, const fs::path& out) {
  std::string rows;
  for (const LeftFile& left : kLeftFiles)
    if (fs::exists(out / left.file))
      rows += fmt::format("<li><a href=\"{0}\">{0}</a>: {1}</li>\n", left.file, left.what);
  if (rows.empty()) return;
  page.add_heading("Files");
  page.add_html("<ul>\n" + rows + "</ul>\n");
}

std::string error_plot(const ExperimentReport& report) {
  return quiver_svg({error_panel("Open loop", report.paper, &TargetResult::before_truth),
                     error_panel("Paper's chain", report.paper, &TargetResult::after_truth),
                     error_panel("planar-servo", report.ours, &TargetResult::after_truth)});
}

/// Returns the plots of the report: the figures of the paper that the data allow, in its order, and
/// before them how the errors are spread and how the loop converges. The steps of the latter are
/// read from the runs in `out`.
std::vector<ReportPlot> experiment_plots(const ExperimentReport& report, const fs::path& out) {
  std::vector<ReportPlot> plots;
  const auto add = [&](std::optional<ReportPlot> plot) {
    if (plot) plots.push_back(std::move(*plot));
  };
  const auto add_all = [&](std::vector<ReportPlot> more) {
    for (ReportPlot& plot : more) plots.push_back(std::move(plot));
  };
  add(spread_plot(report));
  add(convergence_plot(steps_of(out / "ours" / "run"), steps_of(out / "paper" / "run")));
  if (report.recorded) {
    add(lamp_plot(report.recorded->lamps));
    add_all(circle_plots(report.recorded->circles));
    add_all(map_plots(*report.recorded));
  }
  add_all(control_plots(report));
  return plots;
}

/// Returns the text of the page. It links to those files in `out` that exist.
std::string experiment_page(const ExperimentReport& report, const std::string& cell_name,
                            const std::vector<ReportPlot>& plots, const fs::path& out) {
  HtmlPage page("The paper's experiment on " + cell_name);
  add_first_words(page, report);
  page.add_html(error_plot(report));
  page.add_paragraph(
      fmt::format("{} All chains were calibrated from the same recording. {}",
                  report.reflector_sigma
                      ? "Errors of the end point at the control targets, as the cell's tracker "
                        "measured them after the servo had ended."
                      : "True errors of the end point at the control targets, by the scorer of the "
                        "virtual cell, which alone sees the truth.",
                  kQuiverCaption));
  page.add_heading("The paper's tables");
  for (const ShownTable& shown : shown_tables(report)) {
    page.add_html(shown.table.html());
    page.add_paragraph(shown.look_at);
  }
  page.add_paragraph(marks_text(report));
  page.add_paragraph(experiment_list(report).text());
  page.add_heading("Figures");
  page.add_paragraph(
      "The numbers are the paper's. Its Figures 1 to 5, 12 and 17 are drawings and photographs "
      "without data.");
  page.add_html(
      "<figure>\n<figcaption><b>The errors of our chain once more, at scales of their "
      "own.</b></figcaption>\n" +
      quiver_svg({error_panel("planar-servo", report.ours, &TargetResult::after_truth)}) +
      "</figure>\n");
  for (const ReportPlot& plot : plots) add_plot(page, plot, out);
  add_files(page, out);
  return page.text();
}

}  // namespace

fs::path write_experiment_report(const ExperimentReport& report, const std::string& cell_name,
                                 const fs::path& out) {
  const std::vector<ReportPlot> plots = experiment_plots(report, out);
  make_folder(out / "figures");
  for (const ReportPlot& plot : plots)
    write_file(out / "figures" / plot.file, format_comment("figure") + plot.svg);
  write_file(out / "errors.svg", format_comment("figure") + error_plot(report));
  write_file(out / "figures.json",
             with_format_key("figures", experiment_list(report).json().dump(2)));
  fs::path page = out / "report.html";
  write_file(page, experiment_page(report, cell_name, plots, out));
  return page;
}

}  // namespace planar
