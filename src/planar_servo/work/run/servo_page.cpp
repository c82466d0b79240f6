#include "planar_servo/work/run/servo_page.h"

#include <fmt/format.h>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/report/report_list.h"

namespace planar {
namespace {

/// Arrows with a mean this much shorter than that of others are invisible at their scale.
constexpr double kComparable = 0.1;

/// Draws where the arm alone and where vision left the end point: at one scale, unless one of them
/// would not be seen.
void add_error_plots(HtmlPage& page, const ServoFigures& figures,
                     const std::vector<TargetResult>& results) {
  const bool judged = figures.is_judged();
  QuiverPanel alone =
      error_panel("", results, judged ? &TargetResult::before_judged : &TargetResult::before_own);
  QuiverPanel seeing =
      error_panel("", results, judged ? &TargetResult::after_judged : &TargetResult::after_own);
  if (alone.points.empty() || seeing.points.empty()) return;
  alone.title = "The arm alone";
  seeing.title = "With vision";
  page.add_heading(judged ? "Errors against the " + figures.judge()
                          : "Errors by vision's own estimate");
  const double ratio = judged ? figures.after_judged->mean / figures.before_judged->mean
                              : figures.after_own->mean / figures.before_own->mean;
  const bool at_one_scale = ratio > kComparable && ratio * kComparable < 1.0;
  if (at_one_scale) {
    page.add_html(plot_html(quiver_panels({alone, seeing})));
  } else {
    page.add_html(plot_html(quiver_panels({alone})));
    page.add_html(plot_html(quiver_panels({seeing})));
  }
  page.add_paragraph(std::string("Each line leads from a target in the direction of its error; the "
                                 "bar below gives the scale. ") +
                     (at_one_scale
                          ? "Both panels have the same scale and colours."
                          : "The errors differ so much that each panel has its own scale."));
}

std::string error_words(const std::optional<Eigen::Vector2d>& error) {
  return error ? fmt::format("{:.4f}", mm(error->norm())) : "–";
}

TextTable target_table(const ServoFigures& figures, const std::vector<TargetResult>& results) {
  const bool judged = figures.is_judged();
  std::vector<std::string> header{"target",      "x mm",        "y mm",
                                  "corrections", "own view mm", "uncertainty mm"};
  if (judged) header.push_back(figures.judge() + " mm");
  header.emplace_back("status");
  TextTable table("Distance from each target at the end", header);
  for (const TargetResult& r : results) {
    std::vector<std::string> row{
        r.id,
        fixed(mm(r.p_d.x()), 3),
        fixed(mm(r.p_d.y()), 3),
        std::to_string(r.iterations),
        error_words(r.after_own),
        r.uncertainty_m ? fmt::format("{:.4f}", mm(*r.uncertainty_m)) : "–"};
    if (judged) row.push_back(error_words(r.after_judged));
    row.push_back(r.reason.empty() ? name(r.status) : name(r.status) + (": " + r.reason));
    table.add_row(std::move(row));
  }
  return table;
}

Verdict servo_verdict(const ServoFigures& figures, const std::optional<std::string>& ended_by) {
  Verdict verdict{reached_words(figures), run_faults(figures, "the table below"),
                  landing_words(figures)};
  if (ended_by)
    verdict.faults.push_back(
        {"the run was ended at " + *ended_by,
         "mend the cell (planar-check-cell says what has changed), then continue with --resume"});
  if (verdict.found.empty())
    verdict.found = "No end point was measured";
  else if (!figures.is_judged())
    verdict.found +=
        ". Nobody else judged this run, and vision cannot see what its calibration "
        "gets wrong: on a cell with a tracker, --judged measures every target";
  if (!verdict.faults.empty()) verdict.found = verdict.good + ". " + verdict.found;
  return verdict;
}

}  // namespace

std::string servo_page(const std::filesystem::path& cell_file, const ServoFigures& figures,
                       const std::vector<TargetResult>& results,
                       const std::optional<std::string>& ended_by) {
  HtmlPage page("Positioning with " + cell_file.filename().string());
  page.add_verdict(servo_verdict(figures, ended_by));
  page.add_style(".words :is(th,td):last-child{text-align:left}");
  add_error_plots(page, figures, results);
  page.add_heading("Other figures");
  page.add_paragraph(other_list(figures).text());
  page.add_heading("Targets");
  page.add_paragraph(
      "Own view: the distance by vision itself, whose standard uncertainty per axis is stated "
      "beside it." +
      std::string(figures.is_judged() ? " Last distance: by the " + figures.judge() + "." : ""));
  page.add_html("<div class=\"words\">\n" + target_table(figures, results).html() + "</div>\n");
  return page.text();
}

}  // namespace planar
