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

constexpr const char* kWay = "#999";
constexpr const char* kObstacle = "#333";

/// Draws lines as far as they lie within the axes; their points are close together.
void add_within(Panel& panel, const FieldAxes& axes, const Points& points_mm, Panel::Stroke stroke,
                const char* color) {
  Points run;
  const auto end_run = [&] {
    if (run.size() > 1) panel.add_line(run, stroke, color);
    run.clear();
  };
  for (const Eigen::Vector2d& p : points_mm) {
    if (p.x() >= axes.x.from && p.x() <= axes.x.to && p.y() >= axes.y.from && p.y() <= axes.y.to)
      run.push_back(p);
    else
      end_run();
  }
  end_run();
}

/// Returns the outline of a barrier in points that are close together.
Points outline_of(const Barrier& barrier) {
  if (barrier.corners_B.size() == 1) return circle(barrier.corners_B[0], barrier.radius_m);
  constexpr int kPieces = 20;
  Points outline;
  for (std::size_t i = 0; i < barrier.corners_B.size(); ++i) {
    const Eigen::Vector2d &a = barrier.corners_B[i],
                          &b = barrier.corners_B[(i + 1) % barrier.corners_B.size()];
    for (int k = 0; k <= kPieces; ++k) outline.emplace_back(a + (b - a) * k / kPieces);
  }
  return outline;
}

/// Returns a panel over these places, in it what the workspace forbids.
Panel panel_over(const std::string& title, const FieldAxes& axes, const Workspace& workspace) {
  Panel panel(title, axes.x, axes.y, Panel::Aspect::kEqual);
  for (const Border& border : workspace.borders())
    if (border.radius_m > 0.0)
      add_within(panel, axes, in_mm(circle(border.p_B, border.radius_m)), Panel::Stroke::kDashed,
                 kBarred);
  for (const Barrier& barrier : workspace.barriers)
    add_within(panel, axes, in_mm(outline_of(barrier)), Panel::Stroke::kSolid, kObstacle);
  return panel;
}

/// Draws the same in the whole workspace, which has the legend, and by itself.
template <typename Draw, typename Explain>
std::string panels_html(const Points& places, const Workspace& workspace, const Draw& draw,
                        const Explain& explain) {
  const FieldAxes all = axes_over_places(in_mm(circle({0.0, 0.0}, workspace.radius_max_m)));
  const FieldAxes close = axes_over_places(in_mm(places));
  Panel whole = panel_over("In the workspace", all, workspace);
  Panel near = panel_over("By itself", close, workspace);
  draw(whole, all);
  draw(near, close);
  explain(whole);
  whole.add_key(kBarred, "borders and keep-out discs", Panel::Sample::kLine);
  if (!workspace.barriers.empty()) whole.add_key(kObstacle, "obstacles", Panel::Sample::kLine);
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
      [&](Panel& panel, const FieldAxes& /*axes*/) {
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
      [&](Panel& panel, const FieldAxes& axes) {
        add_within(panel, axes, in_mm(way), Panel::Stroke::kSolid, kWay);
        panel.add_dots(in_mm(all), {kSeriesColors[0]}, 3.0);
        panel.add_dots(in_mm(refused), {kSeriesColors[3]}, 4.0);
      },
      [&](Panel& panel) {
        panel.add_key(kSeriesColors[0], "targets");
        panel.add_key(kWay, "the end point's way to them", Panel::Sample::kLine);
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
