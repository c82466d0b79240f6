#include "planar_servo/work/run/plan_page.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/panel.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/report/report_list.h"

namespace planar {
namespace {

using Points = std::vector<Eigen::Vector2d>;

constexpr const char* kBarred = kSeriesColors[1];

Points circle(const Eigen::Vector2d& center, double radius_m) {
  constexpr int kCorners = 90;
  Points points;
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    points.emplace_back(center + radius_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

/// Returns a panel over these places, in it what the workspace forbids.
Panel panel_over(const std::string& title, const Points& places, const Workspace& workspace) {
  const FieldAxes axes = axes_over_places(in_mm(places));
  Panel panel(title, axes.x, axes.y, Panel::Aspect::kEqual);
  for (const Border& border : workspace.borders())
    if (border.radius_m > 0.0)
      panel.add_line(in_mm(circle(border.p_B, border.radius_m)), Panel::Stroke::kDashed, kBarred);
  for (const Barrier& barrier : workspace.barriers) {
    Points outline = barrier.corners_B.size() == 1
                         ? circle(barrier.corners_B[0], barrier.radius_m)
                         : barrier.corners_B;
    outline.push_back(outline.front());
    panel.add_line(in_mm(outline), Panel::Stroke::kSolid, kBarred);
  }
  return panel;
}

/// Draws the same in the whole workspace, which has the legend, and by itself.
template <typename Draw, typename Explain>
std::string panels_html(const Points& places, const Workspace& workspace, const Draw& draw,
                        const Explain& explain) {
  Panel whole =
      panel_over("In the workspace", circle({0.0, 0.0}, workspace.radius_max_m), workspace);
  Panel near = panel_over("By itself", places, workspace);
  draw(whole);
  draw(near);
  explain(whole);
  whole.add_key(kBarred, "borders of workspace, keep-out discs and obstacles", Panel::Sample::kLine);
  return plot_html({whole, near});
}

HtmlPage page_about(const std::filesystem::path& file, const std::vector<std::string>& remarks) {
  HtmlPage page("What " + file.filename().string() + " would have the arm do");
  for (const std::string& remark : remarks) page.add_paragraph(remark + ".");
  return page;
}

}  // namespace

std::string plan_page(const Workspace& workspace, const std::filesystem::path& file,
                      const Path& path, const std::vector<std::string>& remarks) {
  HtmlPage page = page_about(file, remarks);
  const Points places = drawn_places(path);
  page.add_html(panels_html(
      places, workspace,
      [&](Panel& panel) {
        panel.add_line(in_mm(places), Panel::Stroke::kSolid, kSeriesColors[0]);
        panel.add_dots(in_mm({places.front()}), {kSeriesColors[2]}, 4.0);
      },
      [](Panel& panel) {
        panel.add_key(kSeriesColors[0], "the path", Panel::Sample::kLine);
        panel.add_key(kSeriesColors[2], "its beginning");
      }));
  page.add_paragraph(fmt::format("The path is {:.1f} mm long; places are in the base frame.",
                                 mm(path.length_m())));
  return page.text();
}

std::string plan_page(const Workspace& workspace, const std::filesystem::path& file,
                      const std::vector<TargetRow>& targets, const std::vector<DryRunRow>& rows,
                      const std::vector<std::string>& remarks) {
  HtmlPage page = page_about(file, remarks);
  Points all, refused, way;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    all.push_back(targets[i].p_d);
    if (rows.at(i).plan.refusal) refused.push_back(targets[i].p_d);
    way.insert(way.end(), rows[i].way_B.begin(), rows[i].way_B.end());
  }
  page.add_html(panels_html(
      all, workspace,
      [&](Panel& panel) {
        if (!way.empty()) panel.add_line(in_mm(way), Panel::Stroke::kSolid, "#bbb");
        panel.add_dots(in_mm(all), {kSeriesColors[0]}, 3.0);
        panel.add_dots(in_mm(refused), {kSeriesColors[3]}, 4.0);
      },
      [&](Panel& panel) {
        panel.add_key(kSeriesColors[0], "targets");
        panel.add_key("#bbb", "the end point's way to them, in their order", Panel::Sample::kLine);
        if (!refused.empty()) panel.add_key(kSeriesColors[3], "refused");
      }));
  TextTable table("Targets", {"target", "x mm", "y mm", "refused because"});
  for (std::size_t i = 0; i < targets.size(); ++i)
    table.add_row({targets[i].id, fixed(mm(targets[i].p_d.x()), 3),
                   fixed(mm(targets[i].p_d.y()), 3), rows[i].plan.refusal.value_or("")});
  page.add_html("<div class=\"words\">" + table.html() + "</div>");
  return page.text();
}

}  // namespace planar
