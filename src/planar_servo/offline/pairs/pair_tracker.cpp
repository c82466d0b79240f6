#include "planar_servo/offline/pairs/pair_tracker.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "planar_servo/calibration/readings/reading_order.h"
#include "planar_servo/calibration/readings/rests.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/lens/workplane.h"
#include "planar_servo/offline/pairs/lamp_places.h"
#include "planar_servo/offline/pairs/pair_without_tracker.h"
#include "planar_servo/offline/pairs/recording_check.h"
#include "planar_servo/tool/vision_tip.h"

namespace planar {
namespace {

bool serves_fit(Plan plan) {
  return plan == Plan::kTrain || plan == Plan::kSweep1 || plan == Plan::kSweep3;
}

struct SortedReadings {
  std::vector<MonumentReading> begin, end;  ///< of monuments: for the datum, and read once more
  std::vector<TrackerRow> tool;
};

SortedReadings sort_readings(const PairTrackerRequest& request) {
  std::set<std::string> ids, read_first;
  for (const Monument& monument : request.cell.datum) ids.insert(monument.id);
  SortedReadings sorted;
  for (const TrackerRow& row : request.tracker) {
    if (ids.count(row.id) == 0) {
      sorted.tool.push_back(row);
      continue;
    }
    const MonumentReading reading{row.id, row.p_L, request.cell.tracker.sigma_at(row.p_L.norm())};
    if (sorted.tool.empty()) {
      read_first.insert(row.id);
      sorted.begin.push_back(reading);
    } else {
      sorted.end.push_back(reading);
    }
  }
  const auto again = std::stable_partition(
      sorted.end.begin(), sorted.end.end(),
      [&](const MonumentReading& reading) { return read_first.count(reading.id) == 0; });
  sorted.begin.insert(sorted.begin.end(), sorted.end.begin(), again);
  sorted.end.erase(sorted.end.begin(), again);
  return sorted;
}

/// Returns a doubt in words when the monuments read again are not where they were; throws when they
/// are not by far.
std::string doubt_of_drift(const std::vector<Monument>& datum, const SortedReadings& readings) {
  const MonumentVerdict verdict =
      check_drift(monument_sights(datum, readings.begin), monument_sights(datum, readings.end));
  if (verdict.refused) throw InputError(verdict.doubt);
  return verdict.doubt;
}

void add_doubt(const std::string& doubt, PairTrackerReport& report) {
  if (!doubt.empty()) report.doubts.push_back(doubt);
}

void reject(const std::vector<Rejection>& rejected, PairTrackerReport& report) {
  report.rejected.insert(report.rejected.end(), rejected.begin(), rejected.end());
}

/// Registers the tracker by all readings of the monuments, or by the first ones when the last ones
/// differ, and says what moved.
DatumRegistration registered(const std::vector<Monument>& datum, const SortedReadings& readings,
                             PairTrackerReport& report) {
  DatumRegistration registration = register_datum(datum, readings.begin);
  if (registration.left_out)
    report.rejected.push_back({*registration.left_out, registration.doubt});
  add_doubt(registration.doubt, report);
  const std::string drift = doubt_of_drift(datum, readings);
  add_doubt(drift, report);
  if (readings.end.empty() || !drift.empty()) return registration;
  std::vector<MonumentReading> both = readings.begin;
  both.insert(both.end(), readings.end.begin(), readings.end.end());
  return register_datum(datum, both);
}

/// Doubts readings that scatter more than is stated, and takes their scatter for what is stated.
PairTrackerRequest with_honest_tracker(PairTrackerRequest request, PairTrackerReport& report) {
  const RestSpread spread = rest_spread(request);
  if (!is_shaking(spread)) return request;
  report.doubts.push_back(doubt_of_rest(spread));
  request.cell.tracker = with_found_scatter(request.cell.tracker, spread);
  return request;
}

/// Pairs frames and readings by the clocks of both, which it compares first.
Pairing paired_by_time(const std::vector<LampSight>& frames,
                       const std::vector<ToolReading>& readings, PairTrackerReport& report) {
  std::vector<ToolReading> resting = readings_at_rest(readings);
  report.clock = estimate_tracker_clock(frames, resting);
  for (ToolReading& reading : resting) reading.t_s = report.clock->camera_time_s(reading.t_s);
  return pair_sights(frames, resting, PairBy::kTime);
}

/// Pairs frames and readings and takes out those of a frozen tracker.
Pairing paired(const PairTrackerRequest& request, const std::vector<ToolReading>& readings,
               PairTrackerReport& report) {
  const std::vector<LampSight> frames = lamp_sights(request.lamps, request.frames);
  Pairing pairing = request.by == PairBy::kTime ? paired_by_time(frames, readings, report)
                                                : pair_sights(frames, readings, PairBy::kId);
  reject(pairing.rejected, report);
  const std::vector<Rejection> frozen = take_out_frozen(pairing.sights);
  reject(frozen, report);
  if (!frozen.empty())
    report.doubts.push_back(
        fmt::format("tracker: it was frozen at {} places, '{}' first, where its reading did not "
                    "change while the "
                    "lamps moved; they are left out; record them again",
                    frozen.size(), frozen.front().id));
  require_reading_order(pairing.sights, request.by);
  return pairing;
}

WorkplaneFit fit_workplane(const PairTrackerRequest& request,
                           const std::vector<ToolSight>& sights) {
  std::vector<ToolSight> fitted;
  std::copy_if(sights.begin(), sights.end(), std::back_inserter(fitted),
               [](const ToolSight& sight) { return serves_fit(sight.plan); });
  return request.boards_on_plane.empty()
             ? fit_workplane_to_pairs(request.camera, fitted)
             : fit_workplane_to_board(request.camera, poses_of(request.boards_on_plane), fitted,
                                      request.dots_height);
}

/// Adds a row for each place that the plane's fit has not left out: the attended ones, then the
/// unattended. Returns the attended ones with those that it has left out.
std::vector<PairRow> add_rows(const Pairing& places, const Workplane& workplane,
                              const WorkplaneFit& fit, PairTrackerReport& report) {
  std::set<std::string> outliers;
  for (const Rejection& rejection : fit.rejected) outliers.insert(rejection.id);
  std::vector<PairRow> in_time;
  for (const ToolSight& sight : places.sights) {
    const bool is_outlier = outliers.count(sight.id) != 0;
    auto row = seen_row(workplane, fit.tool, sight);
    if (!row) {
      if (!is_outlier) report.rejected.push_back({sight.id, kUnseen});
      continue;
    }
    row->p_tracker = end_point_by_tracker(fit.tool, sight, *row->phi);
    row->p_reflector = sight.p_reflector_B.head<2>();
    row->z_reflector = sight.p_reflector_B.z();
    row->sigma_tracker = sight.sigma_tracker;
    if (!is_outlier) report.pairs.push_back(*row);
    in_time.push_back(std::move(*row));
  }
  add_unattended(workplane, fit, places.unattended, report);
  return in_time;
}

/// Takes out what is so far off that it can be no step.
void take_out_strays(std::vector<PairRow>& in_time) {
  constexpr double kFarOff_m = 3.0 * kMillimetre;
  in_time.erase(std::remove_if(in_time.begin(), in_time.end(),
                               [&](const PairRow& row) { return row.error().norm() > kFarOff_m; }),
                in_time.end());
}

/// Doubts readings that scatter more than is stated, and states for them what they scatter.
void look_for_scatter(const std::vector<PairRow>& in_time, PairTrackerReport& report) {
  const auto scatter = find_scatter(in_time);
  if (!scatter) return;
  report.doubts.push_back(scatter_doubt(*scatter));
  for (PairRow& row : report.pairs)
    if (row.sigma_tracker) *row.sigma_tracker *= scatter->found / scatter->stated;
}

/// Doubts pairs between which something moved at once or by and by; throws when that would cost too
/// much. Places that the plane's fit has left out are asked as well, because after a step near the
/// end of a recording they may be most of those that show it.
void look_for_motion(const PairTrackerRequest& request, const std::vector<PairRow>& in_time,
                     PairTrackerReport& report) {
  const auto add = [&](const std::string& doubt, bool is_dear) {
    if (is_dear && !request.accept_step) throw InputError(doubt);
    report.doubts.push_back(doubt);
  };
  report.step = find_step(in_time);
  if (report.step) return add(step_doubt(*report.step), report.step->is_dear());
  report.trend = find_trend(in_time);
  if (report.trend) add(trend_doubt(*report.trend), report.trend->is_dear());
}

/// Tells who asks for it what was decided.
void log(const PairTrackerReport& report) {
  for (const MonumentResidual& monument : report.datum->residuals)
    spdlog::debug(fmt::format("monument {}: {:.4f} mm off in {} readings", monument.id,
                              monument.residual_B.norm() / kMillimetre, monument.readings));
  spdlog::debug(fmt::format("the workplane is fitted to {} places", report.workplane.n_used));
  for (const std::string& doubt : report.doubts) spdlog::warn(doubt);
  for (const Rejection& rejection : report.rejected)
    spdlog::debug(fmt::format("left out {}: {}", rejection.id, rejection.reason));
}

}  // namespace

PairTrackerReport pair_tracker(const PairTrackerRequest& asked) {
  if (!has_tool_readings(asked)) return pair_without_tracker(asked);
  PairTrackerReport report;
  const PairTrackerRequest request = with_honest_tracker(asked, report);
  const SortedReadings readings = sort_readings(request);
  const DatumRegistration datum = registered(request.cell.datum, readings, report);
  report.datum = datum;
  std::vector<ToolReading> tool_readings;
  for (const TrackerRow& row : readings.tool) {
    tool_readings.push_back(
        {row.id, row.t_s, datum.X_BL * row.p_L, request.cell.tracker.sigma_at(row.p_L.norm())});
  }
  Pairing places = paired(request, tool_readings, report);
  require_axis_in_origin(request.cell, places.sights);
  report.workplane = fit_workplane(request, places.sights);
  const Workplane first(request.camera, report.workplane.X_WC);
  const std::array<double, 2>& diameters = request.cell.lamps.layout.diameters_m;
  report.largest_eccentricity_px = remove_eccentricity(first, diameters, places.sights);
  remove_eccentricity(first, diameters, places.unattended);
  report.workplane = fit_workplane(request, places.sights);
  reject(report.workplane.rejected, report);
  std::vector<PairRow> in_time =
      add_rows(places, Workplane(request.camera, report.workplane.X_WC), report.workplane, report);
  require_upright_tracker(datum, report.workplane.tool);
  require_lamps_in_order(request.cell, request.frames, report.pairs);
  take_out_strays(in_time);
  look_for_motion(request, in_time, report);
  if (!report.step) look_for_scatter(in_time, report);
  log(report);
  return report;
}

Summary raw_error(const std::vector<PairRow>& pairs, std::optional<Plan> plan) {
  std::vector<double> lengths;
  for (const PairRow& pair : pairs) {
    if (pair.is_attended() && (!plan || pair.plan == plan)) lengths.push_back(pair.error().norm());
  }
  return summarize(lengths);
}

}  // namespace planar
