#include "planar_servo/offline/map/map_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"
#include "planar_servo/offline/page/page_of_file.h"
#include "planar_servo/report/figure/figure.h"
#include "planar_servo/report/figure/places.h"
#include "planar_servo/report/quiver_figure.h"

namespace planar {
namespace {

/// Of the cells of a field, every so many along both axes get an arrow.
constexpr std::size_t kArrowSpacing = 3;

/// A map's prediction at the cells of a panel; NaN outside its valid region. Millimetres.
struct FieldValues {
  std::vector<double> sizes, sigmas;
  std::vector<Eigen::Vector2d> arrow_places, arrows;
};

FieldValues field_values(const MapView& view, const std::vector<Eigen::Vector2d>& cells_mm) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  FieldValues values;
  for (std::size_t i = 0; i < cells_mm.size(); ++i) {
    const ErrorPrediction here = view.predict(cells_mm[i] * kMillimetre);
    const Eigen::Vector2d error = here.error / kMillimetre;
    values.sizes.push_back(here.inside ? error.norm() : kNone);
    values.sigmas.push_back(here.inside ? here.sigma / kMillimetre : kNone);
    const bool has_arrow =
        i / kFieldCells % kArrowSpacing == 1 && i % kFieldCells % kArrowSpacing == 1;
    if (!here.inside || !has_arrow) continue;
    values.arrow_places.push_back(cells_mm[i]);
    values.arrows.push_back(error);
  }
  return values;
}

void add_hull(Panel& panel, const ValidRegion& region) {
  std::vector<Eigen::Vector2d> hull = in_mm(region.hull);
  if (hull.empty()) return;
  hull.push_back(hull.front());
  panel.add_line(hull, Panel::Stroke::kDashed);
}

bool any_finite(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(),
                     [](double value) { return std::isfinite(value); });
}

std::string field_figure(const MapView& view) {
  const FieldAxes axes = axes_over_places(in_mm(view.places));
  Panel error("The error that the map predicts", axes.x, axes.y, Panel::Aspect::kEqual);
  Panel uncertainty("How uncertain it is", axes.x, axes.y, Panel::Aspect::kEqual);
  const FieldValues values = field_values(view, error.field_places());
  const ColorScale sizes("size of the error, mm", values.sizes);
  error.add_field(values.sizes, sizes);
  add_hull(error, view.region);
  error.add_arrows(values.arrow_places, values.arrows, arrows_over(values.arrows, "mm"), {"#111"});
  error.add_color_bar(sizes);
  if (!any_finite(values.sigmas)) return figure_svg({error});
  const ColorScale sigmas("standard deviation per axis, mm", values.sigmas,
                          ColorScale::Steps::kDecades);
  uncertainty.add_field(values.sigmas, sigmas);
  add_hull(uncertainty, view.region);
  uncertainty.add_dots(in_mm(view.places), {"#111"}, 1.8);
  uncertainty.add_color_bar(sigmas);
  return figure_svg({error, uncertainty});
}

Panel left_histogram(const MapView& view) {
  if (!view.pulls.empty())
    return histogram("Places left out, over what is stated", "pull, in stated deviations",
                     view.pulls, {1.0, "the stated deviation"});
  const std::vector<double> components = components_of(in_mm(view.left));
  return histogram("Places left out", "what is left per axis, mm", components,
                   {rms(components), "their rms"});
}

/// Which share of the places left out each way misses by no more than so much.
Panel comparison_panel(const std::vector<ComparedField>& ways) {
  constexpr const char* kColors[] = {"#1f4e79", "#d9822b", "#5a8f3d"};
  std::vector<double> far_mm;
  far_mm.reserve(ways.size() + 1);
  for (const ComparedField& way : ways) far_mm.push_back(quantile(way.misses, 0.95) / kMillimetre);
  far_mm.push_back(0.0);
  const Axis miss = axis_over("missed by at most, mm", far_mm);
  Panel panel("What was compared at places left out", miss,
              axis_over("share of the places", {0.0, 1.0}));
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const std::vector<double>& misses = ways[i].misses;
    std::vector<Eigen::Vector2d> line{{0.0, 0.0}};
    for (std::size_t k = 0; k < misses.size() && misses[k] / kMillimetre <= miss.to; ++k)
      line.emplace_back(misses[k] / kMillimetre,
                        static_cast<double>(k + 1) / static_cast<double>(misses.size()));
    const char* color = kColors[i % std::size(kColors)];
    panel.add_line(line, Panel::Stroke::kSolid, color);
    panel.add_key(color, fmt::format("{}: {:.4f} mm rms", ways[i].name, ways[i].rms / kMillimetre));
  }
  return panel;
}

QuiverPanel quiver_of(const std::string& what, const std::vector<Eigen::Vector2d>& places,
                      const std::vector<Eigen::Vector2d>& errors) {
  return {fmt::format("{}: {:.4f} mm rms", what, rms(lengths_of(errors)) / kMillimetre), places,
          errors};
}

}  // namespace

std::string map_page(const MapView& view, const std::filesystem::path& file) {
  HtmlPage page = page_about("Error map", file);
  page.add_verdict(view.verdict);
  page.add_heading("The map");
  page.add_html(field_figure(view));
  page.add_paragraph(
      "Colours fill the region in which the map is valid, the dashed hull of its places and a "
      "margin about it. Lines lead from a place along the error there. Dark parts of the right "
      "panel are gaps: places recorded there help most. " +
      view.what_is_drawn);
  if (!view.left.empty()) {
    page.add_heading("What it is worth");
    const QuiverPanel left = quiver_of("Left out, with the map", view.places, view.left);
    std::vector<Panel> panels =
        quiver_panels({quiver_of("Without the map", view.places, view.raw), left});
    panels.push_back(left_histogram(view));
    page.add_html(figure_svg(panels));
    page.add_paragraph(std::string("Every place is met by what the others say. ") + kQuiverCaption);
    if (!view.compared.empty()) {
      page.add_html(figure_svg({comparison_panel(view.compared)}));
      page.add_paragraph(
          "The first way is taken unless another one's median is smaller by a tenth: of two curves "
          "the left one misses the places by less.");
    }
  }
  page.add_heading("Figures");
  page.add_html("<pre>" + html_escaped(view.text) + "</pre>\n");
  add_provenance(page, file);
  return page.text();
}

}  // namespace planar
