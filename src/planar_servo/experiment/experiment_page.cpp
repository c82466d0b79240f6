#include "planar_servo/experiment/experiment_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/experiment/paper_tables.h"
#include "planar_servo/experiment/plots/plots.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/work/run/servo_report.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Errors this many times the predicted ones put the calibration in question.
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

std::string judged_words(const ExperimentReport& report) {
  return report.reflector_sigma ? "errors measured by the cell's tracker" : "true errors";
}

void add_first_words(HtmlPage& page, const ExperimentReport& report) {
  const ServoFigures ours = figures_of(report.ours), paper = figures_of(report.paper);
  Verdict verdict;
  verdict.faults = run_faults(ours, "ours/run/results.csv");
  if (!ours.after_judged) {
    verdict.faults.push_back({"nobody judged where our chain ends",
                              "clear the tracker's view, and begin in another folder"});
    return page.add_verdict(verdict);
  }
  if (paper.after_judged && ours.after_judged->mean >= paper.after_judged->mean)
    verdict.faults.push_back({"our chain ends no nearer than the paper's",
                              "compare the chains in Tables 3 and 5, and the errors below"});
  const double ratio = ours.after_judged->mean / report.prediction.mean;
  if (ratio > kFarBeyondPrediction)
    verdict.faults.push_back(
        {fmt::format("the error found is {:.1f} times the predicted one", ratio),
         "see where the errors are large below, and record training places there"});
  verdict.good = fmt::format(
      "the end point stops {:.4f} mm from its targets on average, {:.4f} mm at 95 % and {:.4f} mm "
      "at worst ({} at {} targets)",
      mm(ours.after_judged->mean), mm(ours.after_judged->p95), mm(ours.after_judged->max),
      judged_words(report), ours.after_judged->n);
  page.add_verdict(verdict);
  if (!verdict.faults.empty()) page.add_paragraph("Found: " + verdict.good + ".");
}

/// Returns the errors at the targets by each way to go there, and those predicted for ours.
TextTable accuracy_table(const ExperimentReport& report) {
  TextTable table(fmt::format("Distance from the targets: {}", judged_words(report)),
                  {"way", "mean, mm", "at 95 %, mm", "largest, mm"});
  const auto text = [](double metres) { return fmt::format("{:.4f}", mm(metres)); };
  const auto add = [&](const std::string& way, const std::optional<Summary>& found) {
    if (found) table.add_row({way, text(found->mean), text(found->p95), text(found->max)});
  };
  const ServoFigures ours = figures_of(report.ours), paper = figures_of(report.paper);
  add("arm by the cell file, without calibration", paper.before_judged);
  add("the paper's chain", paper.after_judged);
  add("planar-servo, arm alone", ours.before_judged);
  add("planar-servo, with vision", ours.after_judged);
  table.add_row({"planar-servo, as its calibration predicts it", text(report.prediction.mean),
                 text(report.prediction.p95), "–"});
  return table;
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
TextTable worst_table(const ExperimentReport& report) {
  std::vector<const TargetResult*> worst;
  for (const TargetResult& result : report.ours)
    if (result.after_judged) worst.push_back(&result);
  std::stable_sort(worst.begin(), worst.end(), [](const TargetResult* a, const TargetResult* b) {
    return a->after_judged->norm() > b->after_judged->norm();
  });
  worst.resize(std::min<std::size_t>(worst.size(), 5));
  TextTable table("The targets with the largest errors",
                  {"target", "x, mm", "y, mm", "error, mm", "stated deviation per axis, mm"});
  for (const TargetResult* result : worst)
    table.add_row({result->id, fixed(mm(result->p_d.x()), 1), fixed(mm(result->p_d.y()), 1),
                   fixed(mm(result->after_judged->norm()), 4),
                   result->uncertainty_m ? fixed(mm(*result->uncertainty_m), 4) : "–"});
  return table;
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
  for (const LeftFile& left : kLeftFiles)
    if (fs::exists(out / left.file))
      rows += fmt::format("<li><a href=\"{0}\">{0}</a>: {1}</li>\n", left.file, left.what);
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
  const auto add = [](std::vector<ReportPlot>& to, std::optional<ReportPlot> plot) {
    if (plot) to.push_back(std::move(*plot));
  };
  const auto add_paper = [&](std::vector<ReportPlot> more) {
    for (ReportPlot& plot : more) plots.paper.push_back(std::move(plot));
  };
  add(plots.worth, spread_plot(report));
  add(plots.worth,
      convergence_plot(steps_of(out / "ours" / "run"), steps_of(out / "paper" / "run")));
  add(plots.coverage, coverage_plot(report));
  if (report.recorded) {
    add(plots.paper, lamp_plot(report.recorded->lamps));
    add_paper(circle_plots(report.recorded->circles));
    add_paper(map_plots(*report.recorded));
  }
  add_paper(control_plots(report));
  return plots;
}

/// Adds the answers to an engineer's first questions.
void add_results(HtmlPage& page, const ExperimentReport& report, const ReportPlots& plots,
                 const fs::path& out) {
  page.add_heading("Accuracy");
  page.add_html(accuracy_table(report).html());
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
  if (figures_of(report.ours).after_judged) {
    page.add_heading("Largest errors");
    page.add_html(worst_table(report).html());
    page.add_html(plot_html(quiver_panels({errors.back()})));
    page.add_paragraph("The errors of our chain once more, at scales of their own.");
  }
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
