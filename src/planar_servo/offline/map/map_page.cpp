#include "planar_servo/offline/map/map_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/tool/vision_tip.h"
#include "planar_servo/offline/page_of_file.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {
namespace {

/// The share of components within their stated 95 % that does not count as a wrong statement.
constexpr double kLeastCoverage = 0.85;

std::vector<Eigen::Vector2d> columns_of(const Eigen::Matrix2Xd& matrix) {
  std::vector<Eigen::Vector2d> columns;
  for (const auto& column : matrix.colwise()) columns.emplace_back(column);
  return columns;
}

const ValidRegion& region_of(const IdwMap& map) {
  return map.region;
}

template <typename RadialMap>
const ValidRegion& region_of(const RadialMap& map) {
  return map.parameters().region;
}

void add_left_out_pairs(std::size_t left_out, std::size_t all, Verdict& verdict) {
  if (static_cast<double>(left_out) > kFewLeftOut * static_cast<double>(all))
    verdict.faults.push_back(
        {fmt::format("{} of {} pairs contradict the others and were left out", left_out, all),
         "look at the images and readings of the pairs that are named below, and record these "
         "places again"});
}

const Refusal kUseless{
    "the map is not worth using: between its places it removes too little of the error, or no more "
    "than chance would",
    "leave the map out (planar-servo --no-error-map), or record more places; planar-plan proposes "
    "them"};

/// Returns where the lamps are seen when the end point of an average tool is seen at `p`, the tool
/// pointing along x.
std::array<Eigen::Vector2d, 2> lamps_about(const LampFieldFit& fit, const Eigen::Vector2d& p) {
  const Eigen::Vector2d half(0.5 * fit.estimate.nominal.separation, 0.0);
  const Eigen::Vector2d off =
      tip_from_places({Eigen::Vector2d(-half), half}, fit.estimate.nominal.tool).p;
  return {p - off - half, p - off + half};
}

ErrorPrediction prediction_of(const LampFieldFit& fit, const Eigen::Vector2d& p) {
  const CompensatedTip found = compensate(fit.field, lamps_about(fit, p));
  return {p - found.tip.p, per_axis(found.covariance), found.inside};
}

/// Has the view draw a map at the end point, for a tool along the x axis where that matters. The
/// view refers to the map.
void draw_map(const ErrorMap& map, MapView& view) {
  view.region = std::visit([](const auto& kind) { return region_of(kind); }, map);
  const bool turns = depends_on_direction(map);
  const auto phi = turns ? std::optional<double>(0.0) : std::nullopt;
  view.predict = [&map, phi](const Eigen::Vector2d& p) { return predict(map, p, phi); };
  if (turns) view.what_is_drawn = "It is drawn for a tool that points along the x axis.";
}

/// Has it draw a field at the lamps.
void draw_field(const LampFieldFit& fit, MapView& view) {
  view.region = fit.field.region;
  view.predict = [&fit](const Eigen::Vector2d& p) { return prediction_of(fit, p); };
  view.what_is_drawn =
      "The error belongs to where each lamp is seen; it is drawn for the end point of a tool that "
      "points along the x axis.";
}

/// Every n-th square of a drawn field along both axes gets an arrow.
constexpr std::size_t kArrowSpacing = 3;

/// A map's prediction at the squares of a panel; NaN outside its valid region. Millimetres.
struct FieldValues {
  std::vector<double> sizes, sigmas;
  std::vector<Eigen::Vector2d> arrow_places, arrows;
};

FieldValues field_values(const MapView& view, const std::vector<Eigen::Vector2d>& grid_mm) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  FieldValues values;
  for (std::size_t i = 0; i < grid_mm.size(); ++i) {
    const ErrorPrediction here = view.predict(grid_mm[i] * kMillimetre);
    const Eigen::Vector2d error = here.error / kMillimetre;
    values.sizes.push_back(here.inside ? error.norm() : kNone);
    values.sigmas.push_back(here.inside ? mm(here.sigma) : kNone);
    const bool has_arrow =
        i / kFieldCells % kArrowSpacing == 1 && i % kFieldCells % kArrowSpacing == 1;
    if (!here.inside || !has_arrow) continue;
    values.arrow_places.push_back(grid_mm[i]);
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

std::string field_plot(const MapView& view) {
  const FieldAxes axes = axes_over_places(in_mm(view.places));
  Panel error("The error that the map predicts", axes.x, axes.y, Panel::Aspect::kEqual);
  Panel uncertainty("How uncertain it is", axes.x, axes.y, Panel::Aspect::kEqual);
  const FieldValues values = field_values(view, error.field_places());
  const ColorScale sizes("size of the error, mm", values.sizes);
  error.add_field(values.sizes, sizes);
  add_hull(error, view.region);
  error.add_arrows(values.arrow_places, values.arrows, arrows_over(values.arrows, "mm"), {"#111"});
  error.add_color_bar(sizes);
  if (!any_finite(values.sigmas)) return plot_html({error});
  const ColorScale sigmas("standard deviation per axis, mm", values.sigmas,
                          ColorScale::Steps::kDecades);
  uncertainty.add_field(values.sigmas, sigmas);
  add_hull(uncertainty, view.region);
  uncertainty.add_dots(in_mm(view.places), {"#111"}, 1.8);
  uncertainty.add_color_bar(sigmas);
  return plot_html({error, uncertainty});
}

Panel left_histogram(const MapView& view) {
  if (!view.pulls.empty())
    return histogram("Places left out, over what is stated", "pull, in stated deviations",
                     view.pulls, {1.0, "the stated deviation"});
  const std::vector<double> components = components_of(in_mm(view.left));
  return histogram("Places left out", "what is left per axis, mm", components,
                   {rms(components), "their rms"});
}

/// The share of the places left out that each way misses by no more than a given length.
Panel comparison_panel(const std::vector<ComparedField>& ways) {
  std::vector<double> far_mm;
  far_mm.reserve(ways.size() + 1);
  for (const ComparedField& way : ways) far_mm.push_back(mm(quantile(way.misses, 0.95)));
  far_mm.push_back(0.0);
  const Axis miss = axis_over("missed by at most, mm", far_mm);
  Panel panel("What was compared at places left out", miss,
              axis_over("share of the places", {0.0, 1.0}));
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const std::vector<double>& misses = ways[i].misses;
    std::vector<Eigen::Vector2d> line{{0.0, 0.0}};
    for (std::size_t k = 0; k < misses.size() && mm(misses[k]) <= miss.to; ++k)
      line.emplace_back(mm(misses[k]),
                        static_cast<double>(k + 1) / static_cast<double>(misses.size()));
    const char* color = kSeriesColors[i % std::size(kSeriesColors)];
    panel.add_line(line, Panel::Stroke::kSolid, color);
    panel.add_key(color, fmt::format("{}: {:.4f} mm rms", ways[i].name, mm(ways[i].rms)),
                  Panel::Sample::kLine);
  }
  return panel;
}

/// The tables of a list's rows, as far as there are any.
constexpr std::pair<const char*, const char*> kTables[] = {
    {"compared", "Ways to predict the error, compared at places left out"},
    {"comparison", "Methods, compared at places left out"},
    {"sources", "What each source is worth"},
    {"fixed_by", "What fixes the field as a whole"},
    {"cell", "Faults of the cell"},
    {"arm_in_words", "Further findings on the arm"},
    {"terms", "The arm, as found from the poses"},
    {"rejected", "Left out"}};

void add_tables(HtmlPage& page, const ReportList& list) {
  page.add_html(list.table("What was found").html());
  for (const auto& [key, title] : kTables)
    if (list.has_rows(key)) page.add_html(list.table(title, key).html());
}

QuiverPanel quiver_of(const std::string& what, const std::vector<Eigen::Vector2d>& places,
                      const std::vector<Eigen::Vector2d>& errors) {
  return {fmt::format("{}: {:.4f} mm rms", what, mm(rms(lengths_of(errors)))), places, errors};
}

}  // namespace

Verdict map_verdict(const FitErrorMapReport& report) {
  const MapResult& result = report.result;
  Verdict verdict;
  if (!result.worth_using) verdict.faults.push_back(kUseless);
  if (result.worth_using && result.blocked.value >= result.raw_rms)
    verdict.faults.push_back(
        {fmt::format(
             "the map helps only close to its places: in the middle of a part of the field that is "
             "{:.0f} mm wide and has no place, {:.4f} mm rms are left of the error, {:.4f} mm "
             "without a map",
             mm(result.gap), mm(result.blocked.value), mm(result.raw_rms)),
         "record places so near to one another that no such gap stays, first in the dark parts of "
         "the panel of the uncertainty; until then work close to places that were recorded"});
  add_left_out_pairs(result.rejected.size(), result.n_used + result.rejected.size(), verdict);
  verdict.good = fmt::format(
      "worth using: at places left out the error falls from {:.4f} mm rms to {:.4f}, and in a gap "
      "of {:.1f} mm to {:.4f} (95 % interval {:.4f} to {:.4f})",
      mm(result.raw_rms), mm(result.loo_rms), mm(result.gap), mm(result.blocked.value),
      mm(result.blocked.low), mm(result.blocked.high));
  return verdict;
}

Verdict map_verdict(const LampFieldFit& fit) {
  const HeldOut& judged = fit.held_out;
  Verdict verdict;
  if (judged.n == 0)
    verdict.faults.push_back(
        {"no tracker reading judges this map",
         "take a few tracker readings, or check known places with planar-servo before you rely on "
         "it"});
  else if (!judged.worth_using())
    verdict.faults.push_back(kUseless);
  if (judged.n > 0 && judged.coverage_95 < kLeastCoverage)
    verdict.faults.push_back(
        {fmt::format("only {} % of the places left out are within their stated 95 %",
                     fixed(100.0 * judged.coverage_95, 1)),
         "look for something that moved while you recorded: monuments, camera, lamps"});
  add_left_out_pairs(fit.left_out.size(), fit.n_readings + fit.n_unattended, verdict);
  verdict.good = fmt::format(
      "worth using: at places left out the error falls from {:.4f} mm rms to {:.4f}, the tracker's "
      "own noise included, {} % of it within the stated 95 %",
      mm(judged.raw_rms), mm(judged.rms), fixed(100.0 * judged.coverage_95, 1));
  if (!fit.end_point_map)
    verdict.good +=
        fmt::format("; the end point is known to {:.4f} mm per axis", mm(fit.certainty.end_point));
  return verdict;
}

MapView view_of(const FitErrorMapReport& report, const ReportList& list) {
  const MapResult& result = report.result;
  MapView view;
  view.verdict = map_verdict(report);
  view.places = columns_of(result.at_places.positions);
  view.raw = columns_of(result.at_places.errors);
  view.left = columns_of(result.at_places.residuals);
  draw_map(result.map, view);
  view.list = list;
  return view;
}

MapView view_of(const LampFieldFit& fit, const ReportList& list) {
  MapView view;
  view.verdict = map_verdict(fit);
  for (const HeldOutReading& reading : fit.held_out.readings) {
    view.places.push_back(reading.p_seen);
    view.raw.push_back(reading.raw);
    view.left.push_back(reading.left);
    for (int axis = 0; axis < 2; ++axis)
      view.pulls.push_back(reading.left[axis] / reading.sigma[axis]);
  }
  view.compared = fit.compared;
  if (fit.end_point_map)
    draw_map(fit.end_point_map->map, view);
  else
    draw_field(fit, view);
  if (view.places.empty()) view.places = view.region.hull;
  view.list = list;
  return view;
}

std::string map_page(const MapView& view, const std::filesystem::path& file) {
  HtmlPage page = page_about("Error map", file);
  page.add_verdict(view.verdict);
  page.add_heading("The map");
  page.add_html(field_plot(view));
  page.add_paragraph(
      "Colours fill the region in which the map is valid, the dashed hull of its places and a "
      "margin about it. Lines lead from a place along the error there. Dark parts of the "
      "second panel are gaps: places recorded there help most. " +
      view.what_is_drawn);
  if (!view.left.empty()) {
    page.add_heading("Accuracy gained by the map");
    const QuiverPanel left = quiver_of("Left out, with the map", view.places, view.left);
    std::vector<Panel> panels =
        quiver_panels({quiver_of("Without the map", view.places, view.raw), left});
    panels.push_back(left_histogram(view));
    page.add_html(plot_html(panels));
    page.add_paragraph(std::string("Each place is predicted from the others. ") + kQuiverCaption);
    if (!view.compared.empty()) {
      page.add_html(plot_html({comparison_panel(view.compared)}));
      page.add_paragraph(
          "The first way is taken unless another one's median is smaller by a tenth: of two curves "
          "the left one misses the places by less.");
    }
  }
  page.add_heading("In numbers");
  add_tables(page, view.list);
  add_provenance(page, file);
  return page.text();
}

}  // namespace planar
