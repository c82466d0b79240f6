#include "planar_servo/offline/map/map_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/learn/field/arm/arm_fit.h"
#include "planar_servo/offline/calibrate_arm.h"

namespace planar {
namespace {

std::array<double, 2> interval_of(const RmsEstimate& estimate) {
  return {estimate.low, estimate.high};
}

ReportList cell_list(const CellDiagnosis& cell) {
  ReportList list;
  if (cell.terms.empty()) return list;
  list.row_heads("\nfaults of the cell                                    rms, mm");
  for (const CellTerm& term : cell.terms) {
    const CellFaultName& name = name_of(term.fault);
    ReportList row;
    row.line("", fmt::format("{:<20}", name.label));
    row.line("value", fmt::format(" {{value:>10.4g}} +- {{sigma:<8.3g}} {:<7}", name.unit_text),
             term.value / name.unit, term.sigma / name.unit);
    row.line("rms over the field, mm", " {rms_mm:>7.4f}", term.rms);
    row.line("significant", term.significant ? "  significant" : "");
    row.unprinted("significant", term.significant);
    list.row("cell", row);
    list.unprinted(name.key, row.json());
  }
  ReportList left;
  left.line("", "left by all of these");
  left.line("value", "");
  left.line("rms over the field, mm", fmt::format("{:>39.4f}", mm(cell.left_rms)));
  left.line("significant", "");
  list.row("cell", left);
  return list;
}

void list_comparison(ReportList& list, const std::vector<MethodFigures>& comparison) {
  list.row_heads("\nrms, mm        left out: one   a block of neighbours (95 % interval)");
  const auto list_method = [](ReportList& row, const MethodFigures& method) {
    row.line("method",
             std::isfinite(method.loo_rms)
                 ? "{method:<14} "
                 : "{method:<14}             -   its equations cannot be solved",
             method.method);
    row.line("one place left out, mm rms", "{loo_rms_mm:>13.4f}", method.loo_rms);
    row.line("a block of neighbours left out, mm rms", "   {blocked_rms_mm:>8.4f}",
             method.blocked.value);
    row.line_if(std::isfinite(method.blocked.value), "its 95 % interval, mm",
                "  ({blocked_rms_95_mm:.4f| to })", interval_of(method.blocked));
  };
  list.rows("comparison", comparison, list_method, "", "");
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
  if (!fit.left_out.empty())
    list.row_heads(fmt::format("  contradicting the others: {}", fmt::join(fit.left_out, ", ")));
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
  list.row_heads("");
  if (!fit.compared.empty())
    list.row_heads("at places left out            mm rms   within stated 95 %");
  const auto list_way = [&fit](ReportList& row, const ComparedField& way) {
    const bool is_taken = way.rms == fit.held_out.rms;
    row.line("way", "{name:<30}", way.name);
    row.line("places left out, mm rms", "{loo_rms_mm:.4f}   ", way.rms);
    row.line("within their stated 95 %", "{coverage_95:.1%}", way.coverage_95);
    row.line("taken", is_taken ? "  taken" : "");
    row.unprinted("taken", is_taken);
  };
  list.rows("compared", fit.compared, list_way, "", "");
  if (!fit.compared.empty()) list.row_heads("");
}

/// Says what each source added and what fixed the field as a whole.
void list_sources(ReportList& list, const LampFieldFit& fit) {
  list.row_heads("source              how much                  end point known without it to");
  const auto list_source = [](ReportList& row, const SourceWorth& source) {
    row.line("source", "{source:<20}", source.name);
    row.line("how much", "{amount:<26}", source.amount);
    row.line("end point known without it to", "{end_point_without_mm:.4f} mm",
             source.end_point_without);
  };
  list.rows("sources", fit.sources, list_source, "", "");
  ReportList with_all;
  with_all.line("source", fmt::format("{:<20}", "(with all)"));
  with_all.line("how much", fmt::format("{:<26}", ""));
  with_all.line("end point known without it to", "{end_point_sigma_mm:.4f} mm",
                fit.certainty.end_point);
  list.row("sources", with_all);
  list.append_figures(with_all);
  list.row_heads("as a whole          fixed by                  standard deviation");
  ReportList fixed_by;
  const auto list_fixed = [&](const char* what, FieldSource source, const std::string& text,
                              const auto&... sigma) {
    ReportList row;
    fixed_by.unprinted(what, name_in(kFieldSources, source));
    row.line("of the field", fmt::format("{:<20}", what));
    row.line("fixed by", fmt::format("{:<26}", name_in(kFieldSources, source)));
    row.line("standard deviation", text, sigma...);
    list.row("fixed_by", row);
    list.append_figures(row);
  };
  list_fixed("scale", fit.fixed_by.scale, "{scale_sigma_ppm:.1f} ppm", fit.certainty.scale);
  list_fixed("datum", fit.fixed_by.datum, "{datum_sigma_mm:.4f} mm", fit.certainty.shift);
  if (fit.fixed_by.turn == FieldSource::kNothing)
    list_fixed("turn", fit.fixed_by.turn, "counted from the cell file's zero of joint 1");
  else
    list_fixed("turn", fit.fixed_by.turn, "{turn_sigma_deg:.5f} deg", fit.certainty.turn);
  list.part("fixed_by", fixed_by);
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
  list.row_heads("");
  const std::vector<std::string> sentences = arm_in_words(fit.estimate);
  for (const std::string& sentence : sentences) {
    ReportList row;
    row.line("finding", sentence);
    list.row("arm_in_words", row);
  }
  list.unprinted("arm_in_words", sentences);
  list.unprinted("scatter_mm", fit.estimate.priors.arm_sigma);
  list.row_heads("\nthe arm, as found from the poses");
  list.part("arm", arm_terms_list(fit.estimate));
  return list;
}

}  // namespace planar
