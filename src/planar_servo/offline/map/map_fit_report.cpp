#include "planar_servo/offline/map/map_fit_report.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

std::array<double, 2> interval_of(const RmsEstimate& estimate) {
  return {estimate.low, estimate.high};
}

ReportList cell_list(const CellDiagnosis& cell) {
  ReportList list;
  if (cell.terms.empty()) return list;
  list.line("", "\nwhat the pairs say of the cell                        rms, mm");
  for (const CellTerm& term : cell.terms) {
    const CellFaultName& name = name_of(term.fault);
    ReportList part;
    part.line(name.label,
              fmt::format(" {{value:>10.4g}} +- {{sigma:<8.3g}} {:<7} {{rms_mm:>7.4f}}{}",
                          name.unit_text, term.significant ? "  significant" : ""),
              term.value / name.unit, term.sigma / name.unit, term.rms);
    part.unprinted("significant", term.significant);
    list.part(name.key, part);
  }
  list.line("", fmt::format("left by all of these {:>38.4f}", cell.left_rms / kMillimetre));
  return list;
}

void list_comparison(ReportList& list, const std::vector<MethodFigures>& comparison) {
  list.line("", "\nrms, mm        left out: one   a block of neighbours (95 % interval)");
  const auto list_method = [](ReportList& row, const MethodFigures& method) {
    row.line("",
             "{method:<14} {loo_rms_mm:>13.4f}   {blocked_rms_mm:>8.4f}  "
             "({blocked_rms_95_mm:.4f| to })",
             method.method, method.loo_rms, method.blocked.value, interval_of(method.blocked));
    row.line_if(!std::isfinite(method.loo_rms), "",
                "{method:<14}             -   its equations cannot be solved", method.method);
  };
  list.rows("comparison", comparison, list_method, "");
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

}  // namespace

ReportList map_fit_list(const FitErrorMapReport& report,
                        const std::vector<MethodFigures>& comparison) {
  const MapResult& result = report.result;
  ReportList list;
  list.line_if(report.n_other_plans > 0, "left for checking",
               "{n_other_plans} pairs whose plan is not train", report.n_other_plans);
  list.line_if(report.n_unattended > 0, "unattended",
               "{n_unattended} poses without a tracker's word, not used", report.n_unattended);
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

}  // namespace planar
