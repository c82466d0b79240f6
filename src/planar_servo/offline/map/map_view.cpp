#include "planar_servo/offline/map/map_view.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"
#include "planar_servo/offline/page/page_of_file.h"
#include "planar_servo/tool/vision_tip.h"

namespace planar {
namespace {

/// The share of components within their stated 95 % that is not taken for a wrong statement.
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

void judge_left_out_pairs(std::size_t left_out, std::size_t all, Verdict& verdict) {
  if (static_cast<double>(left_out) > kFewLeftOut * static_cast<double>(all))
    verdict.faults.push_back(
        {fmt::format("{} of {} pairs contradict the others and were left out", left_out, all),
         "look at the images and readings of the pairs that are named below, and record these "
         "places again"});
}

const Verdict::Fault kUseless{
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
  return {p - found.tip.p, std::sqrt(0.5 * found.covariance.trace()), found.inside};
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
             result.gap / kMillimetre, result.blocked.value / kMillimetre,
             result.raw_rms / kMillimetre),
         "record places so near to one another that no such gap stays, first in the dark parts of "
         "the right panel; until then work close to places that were recorded"});
  judge_left_out_pairs(result.rejected.size(), result.n_used + result.rejected.size(), verdict);
  verdict.good = fmt::format(
      "worth using: at places left out the error falls from {:.4f} mm rms to {:.4f}, and in a gap "
      "of {:.1f} mm to {:.4f} (95 % interval {:.4f} to {:.4f})",
      result.raw_rms / kMillimetre, result.loo_rms / kMillimetre, result.gap / kMillimetre,
      result.blocked.value / kMillimetre, result.blocked.low / kMillimetre,
      result.blocked.high / kMillimetre);
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
  judge_left_out_pairs(fit.left_out.size(), fit.n_readings + fit.n_unattended, verdict);
  verdict.good = fmt::format(
      "worth using: at places left out the error falls from {:.4f} mm rms to {:.4f}, the tracker's "
      "own noise included, {} % of it within the stated 95 %; the end point is known to {:.4f} mm "
      "per axis",
      judged.raw_rms / kMillimetre, judged.rms / kMillimetre, fixed(100.0 * judged.coverage_95, 1),
      fit.certainty.end_point / kMillimetre);
  return verdict;
}

MapView view_of(const FitErrorMapReport& report, const std::string& text) {
  const MapResult& result = report.result;
  MapView view;
  view.verdict = map_verdict(report);
  view.places = columns_of(result.at_places.positions);
  view.raw = columns_of(result.at_places.errors);
  view.left = columns_of(result.at_places.residuals);
  view.region = std::visit([](const auto& map) { return region_of(map); }, result.map);
  const bool turns = depends_on_direction(result.map);
  const auto phi = turns ? std::optional<double>(0.0) : std::nullopt;
  view.predict = [&result, phi](const Eigen::Vector2d& p) { return predict(result.map, p, phi); };
  if (turns) view.what_is_drawn = "It is drawn for a tool that points along the x axis.";
  view.text = text;
  return view;
}

MapView view_of(const LampFieldFit& fit, const std::string& text) {
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
  view.region = fit.field.region;
  if (view.places.empty()) view.places = view.region.hull;
  view.predict = [&fit](const Eigen::Vector2d& p) { return prediction_of(fit, p); };
  view.what_is_drawn =
      "The error belongs to where each lamp is seen; it is drawn for the end point of a tool that "
      "points along the x axis.";
  view.text = text;
  return view;
}

}  // namespace planar
