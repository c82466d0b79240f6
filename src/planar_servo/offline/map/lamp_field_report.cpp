#include "planar_servo/offline/map/lamp_field_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/field/arm/arm_terms.h"
#include "planar_servo/files/map/lamp_field_file.h"
#include "planar_servo/offline/arm/calibrate_arm.h"

namespace planar {
namespace {

std::string judgement_text(const HeldOut& judged) {
  if (judged.n == 0) return "places left out    none: no tracker reading judges this map\n";
  return fmt::format("vision error        {:.4f} mm rms\n", judged.raw_rms / kMillimetre) +
         fmt::format(
             "places left out     {:.4f} mm rms against the tracker, {} % of them within "
             "their stated 95 %\n",
             judged.rms / kMillimetre, fixed(100.0 * judged.coverage_95, 1)) +
         fmt::format("gain                {} %, {}\n",
                     fixed(100.0 * (1.0 - judged.rms / judged.raw_rms), 1),
                     judged.worth_using() ? "worth using" : "NOT significant: do not use this map");
}

/// Says how the ways to predict the error compare.
std::string comparison_text(const LampFieldFit& fit) {
  if (fit.compared.empty()) return "";
  std::string text = "at places left out            mm rms   within stated 95 %\n";
  for (const ComparedField& way : fit.compared)
    text += fmt::format("{:<30}{:.4f}   {} %{}\n", way.name, way.rms / kMillimetre,
                        fixed(100.0 * way.coverage_95, 1),
                        way.rms == fit.held_out.rms ? ", taken" : "");
  return text + "\n";
}

nlohmann::json comparison_json(const LampFieldFit& fit) {
  nlohmann::json ways = nlohmann::json::array();
  for (const ComparedField& way : fit.compared)
    ways.push_back({{"name", way.name},
                    {"loo_rms_mm", way.rms / kMillimetre},
                    {"coverage_95", way.coverage_95},
                    {"taken", way.rms == fit.held_out.rms}});
  return ways;
}

/// Says what each source added and what fixed the field as a whole.
std::string sources_text(const LampFieldFit& fit) {
  const auto source_line = [](const std::string& name, const std::string& amount, double sigma) {
    return fmt::format("{:<20}{:<26}{:.4f} mm\n", name, amount, sigma / kMillimetre);
  };
  const auto fixed_line = [](const char* what, FieldSource source, const std::string& sigma) {
    return fmt::format("{:<20}{:<26}{}\n", what, name_in(kFieldSources, source), sigma);
  };
  std::string text =
      "source              how much                  end point known without it to\n";
  for (const SourceWorth& source : fit.sources)
    text += source_line(source.name, source.amount, source.end_point_without);
  text += source_line("(with all)", "", fit.certainty.end_point);
  text += "as a whole          fixed by                  standard deviation\n";
  text +=
      fixed_line("scale", fit.fixed_by.scale, fmt::format("{:.1f} ppm", 1e6 * fit.certainty.scale));
  text += fixed_line("datum", fit.fixed_by.datum,
                     fmt::format("{:.4f} mm", fit.certainty.shift / kMillimetre));
  return text + fixed_line("turn", fit.fixed_by.turn,
                           fit.fixed_by.turn == FieldSource::kNothing
                               ? "counted from the cell file's zero of joint 1"
                               : fmt::format("{:.5f} deg", fit.certainty.turn / kDegree));
}

nlohmann::json sources_json(const LampFieldFit& fit) {
  nlohmann::json sources = nlohmann::json::array();
  for (const SourceWorth& source : fit.sources)
    sources.push_back({{"source", source.name},
                       {"amount", source.amount},
                       {"end_point_without_mm", source.end_point_without / kMillimetre}});
  return sources;
}

}  // namespace

std::string lamp_field_report_text(const LampFieldFit& fit) {
  std::string text =
      fmt::format("readings used       {}, and {} poses without a reading ({} left out)\n",
                  fit.n_readings, fit.n_unattended, fit.left_out.size());
  if (!fit.left_out.empty())
    text += fmt::format("  contradicting the others: {}\n", fmt::join(fit.left_out, ", "));
  text += fmt::format("method              {}, {} harmonics of each reducer\n", kLampFieldMethod,
                      fit.estimate.size.harmonics);
  text += judgement_text(fit.held_out);
  text += fmt::format("noise of a lamp     {} times what the pairs state\n",
                      fixed(fit.estimate.priors.lamp_factor, 2));
  text += "\n" + comparison_text(fit) + sources_text(fit) + "\n";
  for (const std::string& sentence : arm_in_words(fit.estimate)) text += sentence + "\n";
  return text + "\n" + arm_terms_text(fit.estimate);
}

nlohmann::json lamp_field_report_json(const LampFieldFit& fit) {
  nlohmann::json rejected = nlohmann::json::array();
  for (const std::string& id : fit.left_out)
    rejected.push_back({{"id", id}, {"reason", "contradicts the others"}});
  nlohmann::json report{{"method", kLampFieldMethod},
                        {"n_used", fit.n_readings + fit.n_unattended - fit.left_out.size()},
                        {"n_readings", fit.n_readings},
                        {"n_unattended", fit.n_unattended},
                        {"n_rejected", fit.left_out.size()},
                        {"rejected", std::move(rejected)},
                        {"harmonics", fit.estimate.size.harmonics},
                        {"noise_mm", fit.noise_sigma / kMillimetre},
                        {"lamp_noise_factor", fit.estimate.priors.lamp_factor},
                        {"worth_using", fit.held_out.worth_using()},
                        {"fixed_by",
                         {{"scale", name_in(kFieldSources, fit.fixed_by.scale)},
                          {"datum", name_in(kFieldSources, fit.fixed_by.datum)},
                          {"turn", name_in(kFieldSources, fit.fixed_by.turn)}}},
                        {"scale_sigma_ppm", 1e6 * fit.certainty.scale},
                        {"datum_sigma_mm", fit.certainty.shift / kMillimetre},
                        {"end_point_sigma_mm", fit.certainty.end_point / kMillimetre},
                        {"sources", sources_json(fit)},
                        {"arm", arm_terms_json(fit.estimate)},
                        {"compared", comparison_json(fit)},
                        {"arm_in_words", arm_in_words(fit.estimate)},
                        {"scatter_mm", fit.estimate.priors.arm_sigma / kMillimetre}};
  if (fit.fixed_by.turn != FieldSource::kNothing)
    report["turn_sigma_deg"] = fit.certainty.turn / kDegree;
  if (fit.held_out.n > 0) {
    report["raw_rms_mm"] = fit.held_out.raw_rms / kMillimetre;
    report["loo_rms_mm"] = fit.held_out.rms / kMillimetre;
    report["gain"] = 1.0 - fit.held_out.rms / fit.held_out.raw_rms;
    report["coverage_95"] = fit.held_out.coverage_95;
  }
  return report;
}

}  // namespace planar
