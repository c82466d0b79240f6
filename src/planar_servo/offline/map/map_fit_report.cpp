#include "planar_servo/offline/map/map_fit_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

std::string cell_text(const CellDiagnosis& cell) {
  if (cell.terms.empty()) return "";
  std::string text = "\nwhat the pairs say of the cell                        rms, mm\n";
  for (const CellTerm& term : cell.terms) {
    const CellFaultName& name = name_of(term.fault);
    text += fmt::format("{:<20} {:>10.4g} +- {:<8.3g} {:<7} {:>7.4f}{}\n", name.label,
                        term.value / name.unit, term.sigma / name.unit, name.unit_text,
                        term.rms / kMillimetre, term.significant ? "  significant" : "");
  }
  return text + fmt::format("left by all of these {:>38.4f}\n", cell.left_rms / kMillimetre);
}

std::string comparison_text(const std::vector<MethodFigures>& comparison) {
  std::string text = "\nrms, mm        left out: one   a block of neighbours (95 % interval)\n";
  for (const MethodFigures& method : comparison) {
    if (!std::isfinite(method.loo_rms)) {
      text += fmt::format("{:<14}             -   its equations cannot be solved\n", method.method);
      continue;
    }
    text += fmt::format("{:<14} {:>13.4f}   {:>8.4f}  ({:.4f} to {:.4f})\n", method.method,
                        method.loo_rms / kMillimetre, method.blocked.value / kMillimetre,
                        method.blocked.low / kMillimetre, method.blocked.high / kMillimetre);
  }
  return text;
}

/// Says how much of the noise the pairs of a place have in common, if places have several.
std::string places_text(const MapResult& result) {
  if (result.places == PlaceSource::kPositions || result.n_places == result.n_used) return "";
  std::string text =
      fmt::format("places              {}, {}\n", result.n_places,
                  result.places == PlaceSource::kFound ? "found from the pairs" : "as named");
  if (std::isfinite(result.place_sigma()))
    text +=
        fmt::format("  noise             {:.4f} mm per axis of a place, {:.4f} mm of a reading\n",
                    result.place_sigma() / kMillimetre, result.reading_sigma() / kMillimetre);
  return text;
}

std::string gap_text(const MapResult& result) {
  const bool better = result.blocked.value < result.raw_rms;
  return fmt::format("in a gap            {:.4f} mm rms where {:.1f} mm are without pairs{}\n",
                     result.blocked.value / kMillimetre, result.gap / kMillimetre,
                     better ? "" : ", no better than without the map");
}

std::string fit_text(const FitErrorMapReport& report) {
  const MapResult& result = report.result;
  std::string text;
  if (report.n_other_plans > 0)
    text +=
        fmt::format("left for checking   {} pairs whose plan is not train\n", report.n_other_plans);
  if (report.n_unattended > 0)
    text += fmt::format("unattended          {} poses without a tracker's word, not used\n",
                        report.n_unattended);
  text +=
      fmt::format("pairs used          {} ({} rejected)\n", result.n_used, result.rejected.size());
  for (const RejectedSample& sample : result.rejected)
    text += fmt::format("  {}: {}\n", sample.id, sample.reason);
  text += fmt::format("method              {}\n", name(kind_of(result.map)));
  text += fmt::format("vision error        {:.4f} mm rms\n", result.raw_rms / kMillimetre);
  text += fmt::format("leave-one-out       {:.4f} mm rms\n", result.loo_rms / kMillimetre);
  text += fmt::format("within stated 95 %  {} % of what places left out show\n",
                      fixed(100.0 * result.coverage_95, 1));
  if (std::isfinite(result.noise_sigma))
    text +=
        fmt::format("noise               {:.4f} mm per axis\n", result.noise_sigma / kMillimetre);
  text += places_text(result);
  if (const auto bias = tool_bias(result.map))
    text += fmt::format("in the tool's frame {} +- {:.4f} mm, used\n",
                        fixed(bias->t / kMillimetre, 4, " "), bias->sigma / kMillimetre);
  text += fmt::format("gain                {} %, {}\n", fixed(100.0 * result.gain(), 1),
                      result.worth_using ? "worth using" : "NOT significant: do not use this map");
  return text + gap_text(result);
}

nlohmann::json interval_mm(const RmsEstimate& estimate) {
  return {estimate.low / kMillimetre, estimate.high / kMillimetre};
}

nlohmann::json comparison_json(const std::vector<MethodFigures>& comparison) {
  nlohmann::json rows = nlohmann::json::array();
  for (const MethodFigures& method : comparison) {
    rows.push_back({{"method", method.method},
                    {"loo_rms_mm", method.loo_rms / kMillimetre},
                    {"blocked_rms_mm", method.blocked.value / kMillimetre},
                    {"blocked_rms_95_mm", interval_mm(method.blocked)}});
  }
  return rows;
}

nlohmann::json cell_json(const CellDiagnosis& cell) {
  nlohmann::json terms = nlohmann::json::object();
  for (const CellTerm& term : cell.terms) {
    const CellFaultName& name = name_of(term.fault);
    terms[name.key] = {{"value", term.value / name.unit},
                       {"sigma", term.sigma / name.unit},
                       {"rms_mm", term.rms / kMillimetre},
                       {"significant", term.significant}};
  }
  return terms;
}

}  // namespace

std::string map_fit_text(const FitErrorMapReport& report,
                         const std::vector<MethodFigures>& comparison) {
  return fit_text(report) + cell_text(report.result.cell) + comparison_text(comparison);
}

nlohmann::json map_fit_json(const FitErrorMapReport& report,
                            const std::vector<MethodFigures>& comparison) {
  const MapResult& result = report.result;
  nlohmann::json rejected = nlohmann::json::array();
  for (const RejectedSample& sample : result.rejected)
    rejected.push_back({{"id", sample.id},
                        {"residual_mm", sample.residual / kMillimetre},
                        {"reason", sample.reason}});
  nlohmann::json keys{{"n_used", result.n_used},
                      {"n_rejected", result.rejected.size()},
                      {"rejected", rejected},
                      {"method", name(kind_of(result.map))},
                      {"raw_rms_mm", result.raw_rms / kMillimetre},
                      {"loo_rms_mm", result.loo_rms / kMillimetre},
                      {"idw_loo_rms_mm", result.idw_loo_rms / kMillimetre},
                      {"blocked_rms_mm", result.blocked.value / kMillimetre},
                      {"blocked_rms_95_mm", interval_mm(result.blocked)},
                      {"cell", cell_json(result.cell)},
                      {"comparison", comparison_json(comparison)},
                      {"noise_mm", result.noise_sigma / kMillimetre},
                      {"gain", result.gain()},
                      {"worth_using", result.worth_using},
                      {"coverage_95", result.coverage_95},
                      {"n_places", result.n_places},
                      {"places", name_in(kPlaceSources, result.places)},
                      {"place_noise_mm", result.place_sigma() / kMillimetre},
                      {"reading_noise_mm", result.reading_sigma() / kMillimetre},
                      {"gap_mm", result.gap / kMillimetre},
                      {"n_other_plans", report.n_other_plans},
                      {"n_unattended", report.n_unattended},
                      {"fit_seconds", report.fit_seconds}};
  if (const auto bias = tool_bias(result.map)) {
    keys["tool_bias_mm"] = {bias->t.x() / kMillimetre, bias->t.y() / kMillimetre};
    keys["tool_bias_sigma_mm"] = bias->sigma / kMillimetre;
  }
  return keys;
}

}  // namespace planar
