#include "planar_servo/experiment/page/experiment_page.h"

#include "planar_servo/experiment/experiment_report.h"
#include "planar_servo/experiment/tables/table_texts.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/quiver_figure.h"
#include "planar_servo/run/servo_report.h"

namespace planar {

std::string experiment_figure(const ExperimentReport& report) {
  return quiver_svg({error_panel("Open loop", report.paper, &TargetResult::before_truth),
                     error_panel("Paper's chain", report.paper, &TargetResult::after_truth),
                     error_panel("planar-servo", report.ours, &TargetResult::after_truth)});
}

std::string experiment_page(const ExperimentReport& report, const std::string& cell_name) {
  HtmlPage page("The paper's experiment on " + cell_name);
  page.add_paragraph(
      "Mean true error of the end point at the control targets, by the scorer of the virtual cell. "
      "Both chains were calibrated from the same recording and saw nothing else.");
  page.add_html(experiment_figure(report));
  page.add_paragraph(kQuiverCaption);
  page.add_html(quiver_svg({error_panel("planar-servo", report.ours, &TargetResult::after_truth)}));
  page.add_paragraph("The last panel once more, at scales of its own.");
  for (const ShownTable& shown : shown_tables(report)) {
    page.add_html(shown.table.html());
    page.add_paragraph(shown.look_at);
  }
  page.add_paragraph(marks_text(report));
  page.add_paragraph(summary_text(report));
  return page.text();
}

}  // namespace planar
