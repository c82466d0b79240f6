#include "planar_servo/offline/pairs/pair_tracker_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

std::string raw_error_text(const std::vector<PairRow>& pairs) {
  std::string text;
  for (const Plan plan : values_of(kPlans)) {
    if (std::none_of(pairs.begin(), pairs.end(),
                     [&](const PairRow& pair) { return pair.is_attended() && pair.plan == plan; }))
      continue;
    const Summary raw = raw_error(pairs, plan);
    text += fmt::format("raw error  {}: {} pairs, mean {:.3f} mm, rms {:.3f} mm, max {:.3f} mm\n",
                        name(plan), raw.n, raw.mean / kMillimetre, raw.rms / kMillimetre,
                        raw.max / kMillimetre);
  }
  return text;
}

std::size_t unattended(const std::vector<PairRow>& pairs) {
  return static_cast<std::size_t>(
      std::count_if(pairs.begin(), pairs.end(), [](const PairRow& p) { return !p.is_attended(); }));
}

}  // namespace

std::string pair_tracker_text(const PairTrackerReport& report) {
  const WorkplaneFit& fit = report.workplane;
  std::string text = fmt::format("datum      {} monuments, rms {:.3f} mm\n",
                                 report.datum.residuals.size(), report.datum.rms / kMillimetre);
  text += fmt::format("workplane  {} degrees of freedom fitted to {} places, rms {:.3f} mm\n",
                      fit.absorbed, fit.n_used, fit.rms / kMillimetre);
  text += fmt::format("tool       end point ({}) mm, reflector ({}) mm\n",
                      fixed(fit.tool.p_TP / kMillimetre, 3, ", "),
                      fixed(fit.tool.p_TS.head<2>() / kMillimetre, 3, ", "));
  text += fmt::format("lamps      eccentricity of their discs up to {:.4f} px, taken off\n",
                      report.largest_eccentricity_px);
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
  const Eigen::Vector3d p_TS = fit.tool.p_TS / kMillimetre;
  auto rejected = nlohmann::json::array();
  for (const Rejection& rejection : report.rejected)
    rejected.push_back({{"id", rejection.id}, {"reason", rejection.reason}});
  const Summary raw = raw_error(report.pairs);
  const auto n_unattended = unattended(report.pairs);
  return {{"pairs", report.pairs.size() - n_unattended},
          {"unattended", n_unattended},
          {"rejected", rejected},
          {"doubts", report.doubts},
          {"datum_rms_mm", report.datum.rms / kMillimetre},
          {"workplane_rms_mm", fit.rms / kMillimetre},
          {"workplane_absorbed", fit.absorbed},
          {"eccentricity_px_max", report.largest_eccentricity_px},
          {"p_TP_mm", {p_TP.x(), p_TP.y()}},
          {"p_TS_mm", {p_TS.x(), p_TS.y(), p_TS.z()}},
          {"raw_mean_mm", raw.mean / kMillimetre},
          {"raw_rms_mm", raw.rms / kMillimetre}};
}

}  // namespace planar
