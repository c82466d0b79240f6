#include "planar_servo/offline/pairs/pair_tracker_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// Returns the raw error of the pairs of each plan that has some.
std::vector<std::pair<Plan, Summary>> raw_errors(const std::vector<PairRow>& pairs) {
  std::vector<std::pair<Plan, Summary>> raw;
  for (const Plan plan : values_of(kPlans))
    if (std::any_of(pairs.begin(), pairs.end(),
                    [&](const PairRow& pair) { return pair.is_attended() && pair.plan == plan; }))
      raw.emplace_back(plan, raw_error(pairs, plan));
  return raw;
}

std::string raw_error_text(const std::vector<PairRow>& pairs) {
  std::string text;
  for (const auto& [plan, raw] : raw_errors(pairs))
    text += fmt::format("raw error  {}: {} pairs, mean {:.3f} mm, rms {:.3f} mm, max {:.3f} mm\n",
                        name(plan), raw.n, raw.mean / kMillimetre, raw.rms / kMillimetre,
                        raw.max / kMillimetre);
  return text;
}

nlohmann::json raw_error_json(const std::vector<PairRow>& pairs) {
  auto by_plan = nlohmann::json::object();
  for (const auto& [plan, raw] : raw_errors(pairs))
    by_plan[std::string(name(plan))] = {{"pairs", raw.n},
                                        {"mean_mm", raw.mean / kMillimetre},
                                        {"rms_mm", raw.rms / kMillimetre},
                                        {"max_mm", raw.max / kMillimetre}};
  return by_plan;
}

std::string clock_text(const TrackerClock& clock) {
  return fmt::format(
      "clock      the tracker's is {:.3f} s ahead of the camera's, +- {:.3f}, and runs {:.1f} +- "
      "{:.1f} ppm fast, by {} places\n",
      clock.offset_s, clock.sigma_offset_s, 1e6 * clock.rate, 1e6 * clock.sigma_rate, clock.places);
}

std::size_t unattended(const std::vector<PairRow>& pairs) {
  return static_cast<std::size_t>(
      std::count_if(pairs.begin(), pairs.end(), [](const PairRow& p) { return !p.is_attended(); }));
}

std::string datum_text(const std::optional<DatumRegistration>& datum) {
  if (!datum)
    return "datum      no tracker reading: place and turn are those of the commanded arm\n";
  return fmt::format("datum      {} monuments, rms {:.3f} mm\n", datum->residuals.size(),
                     datum->rms / kMillimetre);
}

std::string tool_line(const ToolOffsets& tool) {
  return fmt::format("tool       end point ({}) mm, reflector {}\n",
                     fixed(tool.p_TP / kMillimetre, 3, ", "),
                     tool.reflector_known
                         ? fmt::format("({}) mm", fixed(tool.p_TS.head<2>() / kMillimetre, 3, ", "))
                         : "not known");
}

}  // namespace

std::string pair_tracker_text(const PairTrackerReport& report) {
  const WorkplaneFit& fit = report.workplane;
  std::string text = datum_text(report.datum);
  text += fmt::format("workplane  {} degrees of freedom fitted to {} places, rms {:.3f} mm\n",
                      fit.absorbed, fit.n_used, fit.rms / kMillimetre);
  text += tool_line(fit.tool);
  text += fmt::format("lamps      eccentricity of their discs up to {:.4f} px, taken off\n",
                      report.largest_eccentricity_px);
  if (report.clock) text += clock_text(*report.clock);
  for (const Rejection& rejection : report.rejected)
    text += fmt::format("rejected   {}: {}\n", rejection.id, rejection.reason);
  text += raw_error_text(report.pairs);
  if (const auto n = unattended(report.pairs); n > 0)
    text += fmt::format("unattended {} poses that only the camera watched\n", n);
  return text;
}

nlohmann::json pair_tracker_json(const PairTrackerReport& report) {
  const WorkplaneFit& fit = report.workplane;
  const Eigen::Vector2d p_TP = fit.tool.p_TP / kMillimetre;
  auto rejected = nlohmann::json::array();
  for (const Rejection& rejection : report.rejected)
    rejected.push_back({{"id", rejection.id}, {"reason", rejection.reason}});
  const auto n_unattended = unattended(report.pairs);
  nlohmann::json json{{"pairs", report.pairs.size() - n_unattended},
                      {"unattended", n_unattended},
                      {"rejected", rejected},
                      {"doubts", report.doubts},
                      {"workplane_rms_mm", fit.rms / kMillimetre},
                      {"workplane_absorbed", fit.absorbed},
                      {"workplane_places", fit.n_used},
                      {"eccentricity_px_max", report.largest_eccentricity_px},
                      {"p_TP_mm", {p_TP.x(), p_TP.y()}}};
  if (!report.datum) return json;
  const Eigen::Vector3d p_TS = fit.tool.p_TS / kMillimetre;
  const Summary raw = raw_error(report.pairs);
  json["datum_rms_mm"] = report.datum->rms / kMillimetre;
  json["monuments"] = report.datum->residuals.size();
  json["p_TS_mm"] = {p_TS.x(), p_TS.y(), p_TS.z()};
  json["raw_mean_mm"] = raw.mean / kMillimetre;
  json["raw_rms_mm"] = raw.rms / kMillimetre;
  json["raw"] = raw_error_json(report.pairs);
  if (report.clock)
    json["clock"] = {{"offset_s", report.clock->offset_s},
                     {"sigma_offset_s", report.clock->sigma_offset_s},
                     {"rate_ppm", 1e6 * report.clock->rate},
                     {"sigma_rate_ppm", 1e6 * report.clock->sigma_rate},
                     {"places", report.clock->places}};
  return json;
}

}  // namespace planar
