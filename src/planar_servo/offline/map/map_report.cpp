#include "planar_servo/offline/map/map_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/learn/field/arm/arm_fit.h"
#include "planar_servo/offline/calibrate_arm.h"
#include "planar_servo/offline/page_of_file.h"
#include "planar_servo/report/places.h"
#include "planar_servo/report/plot.h"

namespace planar {

namespace {

std::array<double, 2> interval_of(const RmsEstimate& estimate) {
  return {estimate.low, estimate.high};
}

ReportList cell_list(const CellDiagnosis& cell) {
  ReportList list;
  if (cell.terms.empty()) return list;
  for (const CellTerm& term : cell.terms) {
    const CellFaultName& name = name_of(term.fault);
    ReportList& row = list.row("cell");
    row.line("fault", name.label);
    row.line("value", std::string("{value:.4g} +- {sigma:.3g} ") + name.unit_text,
             term.value / name.unit, term.sigma / name.unit);
    row.line("rms over the field, mm", "{rms_mm:.4f}", term.rms);
    row.line("significant", term.significant ? "significant" : "");
    row.unprinted("significant", term.significant);
    list.unprinted(name.key, row.json());
  }
  list.row("cell", {{"", "left by all of these"}, {"", ""}, {"", fixed(mm(cell.left_rms), 4)}});
  list.show("cell", "Faults of the cell", ReportList::Shown::kAlsoInPrint);
  return list;
}

void list_comparison(ReportList& list, const std::vector<MethodFigures>& comparison) {
  list.rows("comparison", comparison, [](ReportList& row, const MethodFigures& method) {
    row.line(
        "method",
        std::isfinite(method.loo_rms) ? "{method}" : "{method}: its equations cannot be solved",
        method.method);
    row.line("one place, mm rms", "{loo_rms_mm:.4f}", method.loo_rms);
    row.line("a block of neighbours, mm rms", "{blocked_rms_mm:.4f}", method.blocked.value);
    row.line_if(std::isfinite(method.blocked.value), "its 95 % interval, mm",
                "{blocked_rms_95_mm:.4f| to }", interval_of(method.blocked));
  });
  list.show("comparison", "Methods, compared at places left out", ReportList::Shown::kAlsoInPrint);
}

/// Says how much of the noise the pairs of a place have in common, if places have several.
void list_places(ReportList& list, const MapResult& result) {
  const bool has_places =
      result.places != PlaceSource::kPositions && result.n_places != result.n_used;
  list.unprinted("places", name_in(kPlaceSources, result.places));
  list.line_if(has_places, "places",
               result.places == PlaceSource::kFound ? "{n_places}, found from the pairs"
                                                    : "{n_places}, as named",
               result.n_places);
  list.line_if(
      has_places, "  noise",
      "{place_noise_mm:.4f} mm per axis of a place, {reading_noise_mm:.4f} mm of a reading",
      result.place_sigma(), result.reading_sigma());
}

void list_readings(ReportList& list, const LampFieldFit& fit) {
  list.line("readings used",
            "{n_readings}, and {n_unattended} poses without a reading ({n_rejected} left out)",
            fit.n_readings, fit.n_unattended, fit.left_out.size());
  list.unprinted("n_used", fit.n_readings + fit.n_unattended - fit.left_out.size());
  list.line_if(!fit.left_out.empty(), "left out",
               fmt::format("{}: they contradict the others", fmt::join(fit.left_out, ", ")));
  list.rows("rejected", fit.left_out, [](ReportList& row, const std::string& id) {
    row.line("pair", "{id}", id);
    row.line("why", "{reason}", "contradicts the others");
  });
}

void list_held_out(ReportList& list, const HeldOut& judged) {
  list.unprinted("worth_using", judged.worth_using());
  if (judged.n == 0) {
    list.line("places left out", "none: no tracker reading judges this map");
    return;
  }
  list.line("vision error", "{raw_rms_mm:.4f} mm rms", judged.raw_rms);
  list.line("places left out",
            "{loo_rms_mm:.4f} mm rms against the tracker, {coverage_95:.1%} of them within their "
            "stated 95 %",
            judged.rms, judged.coverage_95);
  list.line("gain",
            judged.worth_using() ? "{gain:.1%}, worth using"
                                 : "{gain:.1%}, NOT significant: do not use this map",
            1.0 - judged.rms / judged.raw_rms);
}

/// Says how the ways to predict the error compare.
void list_comparison(ReportList& list, const LampFieldFit& fit) {
  list.rows("compared", fit.compared, [&fit](ReportList& row, const ComparedField& way) {
    const bool is_taken = way.rms == fit.held_out.rms;
    row.line("way", "{name}", way.name);
    row.line("mm rms", "{loo_rms_mm:.4f}", way.rms);
    row.line("within their stated 95 %", "{coverage_95:.1%}", way.coverage_95);
    row.line("taken", is_taken ? "taken" : "");
    row.unprinted("taken", is_taken);
  });
  list.show("compared", "Ways to predict the error, compared at places left out",
            ReportList::Shown::kAlsoInPrint);
}

/// Returns whether the turn would count from the cell file's zero, without a deviation, were it not
/// for this source.
bool alone_fixes_turn(const LampFieldFit& fit, const SourceWorth& source) {
  const auto fixes = [](const SourceWorth& any) {
    return any.name == name_in(kFieldSources, FieldSource::kTracker) ||
           any.name == name_in(kFieldSources, FieldSource::kMarks);
  };
  return fixes(source) && fit.fixed_by.turn != FieldSource::kNothing &&
         std::count_if(fit.sources.begin(), fit.sources.end(), fixes) == 1;
}

/// Says what each source added and what fixed the field as a whole.
void list_sources(ReportList& list, const LampFieldFit& fit) {
  list.rows("sources", fit.sources, [&](ReportList& row, const SourceWorth& source) {
    row.line("source", "{source}", source.name);
    row.line("how much", "{amount}", source.amount);
    row.line("end point known without it to",
             alone_fixes_turn(fit, source) ? "{end_point_without_mm:.4f} mm but for the turn"
                                           : "{end_point_without_mm:.4f} mm",
             source.end_point_without);
  });
  list.row("sources",
           {{"", "(with all)"}, {"", ""}, {"", fixed(mm(fit.certainty.end_point), 4) + " mm"}});
  list.unprinted("end_point_sigma_mm", fit.certainty.end_point);
  list.show("sources", "What each source is worth", ReportList::Shown::kAlsoInPrint);
  ReportList fixed_by;
  const auto list_fixed = [&](const char* what, FieldSource source, const std::string& text,
                              const auto&... sigma) {
    ReportList& row = list.row("fixed_by");
    row.line("of the field", what);
    row.line("fixed by", name_in(kFieldSources, source));
    row.line("standard deviation", text, sigma...);
    fixed_by.unprinted(what, name_in(kFieldSources, source));
    list.append_figures(row);
  };
  list_fixed("scale", fit.fixed_by.scale, "{scale_sigma_ppm:.1f} ppm", fit.certainty.scale);
  list_fixed("datum", fit.fixed_by.datum, "{datum_sigma_mm:.4f} mm", fit.certainty.shift);
  if (fit.fixed_by.turn == FieldSource::kNothing)
    list_fixed("turn", fit.fixed_by.turn, "counted from the cell file's zero of joint 1");
  else
    list_fixed("turn", fit.fixed_by.turn, "{turn_sigma_deg:.5f} deg", fit.certainty.turn);
  list.part("fixed_by", fixed_by);
  list.show("fixed_by", "What fixes the field as a whole", ReportList::Shown::kAlsoInPrint);
}

/// The share of components within their stated 95 % that does not count as a wrong statement.
constexpr double kLeastCoverage = 0.85;

std::vector<Eigen::Vector2d> columns_of(const Eigen::Matrix2Xd& matrix) {
  return each(matrix.colwise(), [](const auto& column) { return Eigen::Vector2d(column); });
}

constexpr char kContradicting[] = "pairs contradict the others and were";

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

/// Has the view draw a map at the end point, for a tool along the x axis where that matters. The
/// view refers to the map.
void draw_map(const ErrorMap& map, MapView& view) {
  view.region = valid_region(map);
  const bool turns = depends_on_direction(map);
  const auto phi = turns ? std::optional<double>(0.0) : std::nullopt;
  view.predict = [&map, phi](const Eigen::Vector2d& p) { return predict(map, p, phi); };
  if (turns) view.what_is_drawn = "It is drawn for a tool that points along the x axis.";
}

/// Has it draw a field at the lamps.
void draw_field(const LampFieldFit& fit, MapView& view) {
  view.region = fit.field.region;
  view.predict = [&fit](const Eigen::Vector2d& p) -> ErrorPrediction {
    const CompensatedTip found = compensate(fit.field, lamps_about(fit, p));
    return {p - found.tip.p, per_axis(found.covariance), found.inside};
  };
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

std::string field_plot(const MapView& view) {
  const FieldAxes axes = axes_over_places(in_mm(view.places));
  Panel error("The error that the map predicts", axes), uncertainty("How uncertain it is", axes);
  const FieldValues values = field_values(view, error.field_places());
  const ColorScale sizes("size of the error, mm", values.sizes);
  error.add_field(values.sizes, sizes);
  add_hull(error, view.region);
  error.add_arrows(values.arrow_places, values.arrows, arrows_over(values.arrows, "mm"), {"#111"});
  error.add_color_bar(sizes);
  if (std::none_of(values.sigmas.begin(), values.sigmas.end(),
                   [](double sigma) { return std::isfinite(sigma); }))
    return plot_html({error});
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
  std::vector<double> far_mm =
      each(ways, [](const ComparedField& way) { return mm(quantile(way.misses, 0.95)); });
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

QuiverPanel quiver_of(const std::string& what, const std::vector<Eigen::Vector2d>& places,
                      const std::vector<Eigen::Vector2d>& errors) {
  return {fmt::format("{}: {:.4f} mm rms", what, mm(rms(lengths_of(errors)))), places, errors};
}

}  // namespace

ReportList map_fit_list(const FitErrorMapReport& report,
                        const std::vector<MethodFigures>& comparison) {
  const MapResult& result = report.result;
  ReportList list;
  list.line_if(report.n_other_plans > 0, "left for checking",
               "{n_other_plans} pairs whose plan is not train", report.n_other_plans);
  list.line_if(report.n_unattended > 0, "unattended",
               "{n_unattended} poses without a tracker reading, not used", report.n_unattended);
  list.line("pairs used", "{n_used} ({n_rejected} rejected)", result.n_used,
            result.rejected.size());
  const auto list_rejected = [](ReportList& row, const RejectedSample& sample) {
    row.line("pair", "{id}", sample.id);
    row.line("why", "{reason}", sample.reason);
    row.unprinted("residual_mm", sample.residual);
  };
  list.rows("rejected", result.rejected, list_rejected, "  ");
  list.line("method", "{method}", name(kind_of(result.map)));
  list.line("vision error", "{raw_rms_mm:.4f} mm rms", result.raw_rms);
  list.line("leave-one-out", "{loo_rms_mm:.4f} mm rms", result.loo_rms);
  list.unprinted("idw_loo_rms_mm", result.idw_loo_rms);
  list.line("within stated 95 %", "{coverage_95:.1%} of what places left out show",
            result.coverage_95);
  list.line("noise", "{noise_mm:.4f} mm per axis", result.noise_sigma);
  list_places(list, result);
  if (const auto bias = tool_bias(result.map))
    list.line("in the tool's frame", "{tool_bias_mm:.4f| } +- {tool_bias_sigma_mm:.4f} mm, used",
              bias->t, bias->sigma);
  list.line("gain",
            result.worth_using ? "{gain:.1%}, worth using"
                               : "{gain:.1%}, NOT significant: do not use this map",
            result.gain());
  list.unprinted("worth_using", result.worth_using);
  list.line("in a gap",
            result.blocked.value < result.raw_rms
                ? "{blocked_rms_mm:.4f} mm rms where {gap_mm:.1f} mm are without pairs"
                : "{blocked_rms_mm:.4f} mm rms where {gap_mm:.1f} mm are without pairs, no better "
                  "than without the map",
            result.blocked.value, result.gap);
  list.unprinted("blocked_rms_95_mm", interval_of(result.blocked));
  list.part("cell", cell_list(result.cell));
  list_comparison(list, comparison);
  list.show("rejected", "Left out");
  list.unprinted("fit_seconds", report.fit_seconds);
  return list;
}

ReportList lamp_field_list(const LampFieldFit& fit) {
  ReportList list;
  list_readings(list, fit);
  if (fit.end_point_map)
    list.line("method", "{method} at the end point", name(kind_of(fit.end_point_map->map)));
  else
    list.line("method", "{method}, {harmonics} harmonics of each reducer", kLampFieldMethod,
              fit.estimate.size.harmonics);
  list_held_out(list, fit.held_out);
  list.line("noise of a lamp", "{lamp_noise_factor:.2f} times what the pairs state",
            fit.estimate.priors.lamp_factor);
  list.unprinted("noise_mm", fit.noise_sigma);
  list_comparison(list, fit);
  if (!fit.end_point_map) list_sources(list, fit);  // which are of the field
  const std::vector<std::string> sentences = arm_in_words(fit.estimate);
  for (const std::string& sentence : sentences) list.row("arm_in_words", {{"finding", sentence}});
  list.show("arm_in_words", "Further findings on the arm", ReportList::Shown::kAlsoInPrint);
  list.unprinted("arm_in_words", sentences);
  list.unprinted("scatter_mm", fit.estimate.priors.arm_sigma);
  list.part("arm", arm_terms_list(fit.estimate));
  return list;
}

Verdict map_verdict(const FitErrorMapReport& report) {
  const MapResult& result = report.result;
  Verdict verdict;
  if (!result.worth_using) verdict.faults.push_back(kUseless);
  if (result.worth_using && result.blocked.value >= result.raw_rms)
    verdict.doubt(
        fmt::format(
            "the map helps only close to its places: in the middle of a part of the field that is "
            "{:.0f} mm wide and has no place, {:.4f} mm rms are left of the error, {:.4f} mm "
            "without a map",
            mm(result.gap), mm(result.blocked.value), mm(result.raw_rms)),
        "record places so near to one another that no such gap stays, first in the dark parts of "
        "the panel of the uncertainty; until then work close to places that were recorded");
  doubt_left_out(result.rejected.size(), result.n_used + result.rejected.size(), kContradicting,
                 verdict);
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
    verdict.doubt(
        "no tracker reading judges this map",
        "take a few tracker readings, or check known places with planar-servo before you rely on "
        "it");
  else if (!judged.worth_using())
    verdict.faults.push_back(kUseless);
  if (judged.n > 0 && judged.coverage_95 < kLeastCoverage)
    verdict.doubt(fmt::format("only {} % of the places left out are within their stated 95 %",
                              fixed(100.0 * judged.coverage_95, 1)),
                  "look for something that moved while you recorded: monuments, camera, lamps");
  doubt_left_out(fit.left_out.size(), fit.n_readings + fit.n_unattended, kContradicting, verdict);
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
  const std::vector<HeldOutReading>& readings = fit.held_out.readings;
  view.places = each(readings, &HeldOutReading::p_seen);
  view.raw = each(readings, &HeldOutReading::raw);
  view.left = each(readings, &HeldOutReading::left);
  for (const HeldOutReading& reading : readings)
    for (int axis = 0; axis < 2; ++axis)
      view.pulls.push_back(reading.left[axis] / reading.sigma[axis]);
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
  HtmlPage page = page_about("Error map", file, view.verdict);
  page.add_section(
      "The map", field_plot(view),
      "Colours fill the region in which the map is valid, the dashed hull of its places and a "
      "margin about it. Lines lead from a place along the error there. Dark parts of the "
      "second panel are gaps: places recorded there help most. " +
          view.what_is_drawn);
  if (!view.left.empty()) {
    const QuiverPanel left = quiver_of("Left out, with the map", view.places, view.left);
    std::vector<Panel> panels =
        quiver_panels({quiver_of("Without the map", view.places, view.raw), left});
    panels.push_back(left_histogram(view));
    page.add_section("Accuracy gained by the map", plot_html(panels),
                     std::string("Each place is predicted from the others. ") + kQuiverCaption);
    if (!view.compared.empty()) {
      page.add_html(plot_html({comparison_panel(view.compared)}));
      page.add_paragraph(
          "The first way is taken unless another one's median is smaller by a tenth: of two curves "
          "the left one misses the places by less.");
    }
  }
  return ended_page(std::move(page), view.list, file);
}

}  // namespace planar
