#include "planar_servo/offline/pairs/pair_tracker.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/lens/workplane.h"
#include "planar_servo/geometry/tool/tips.h"

namespace planar {
namespace {

/// Moves the lamps' places from the centres of their images to the images of their centres, for
/// discs of these diameters (metres) in the plane. Returns the largest shift, pixels.
template <typename Sight>
double remove_eccentricity(const Workplane& workplane, const std::array<double, 2>& diameters,
                           std::vector<Sight>& sights) {
  double largest_px = 0.0;
  for (Sight& sight : sights) {
    const auto shifts_px = lamp_eccentricities_px(workplane, sight.lamps_px, diameters);
    for (std::size_t k = 0; k < 2; ++k) {
      sight.lamps_px[k] -= shifts_px[k];
      largest_px = std::max(largest_px, shifts_px[k].norm());
    }
  }
  return largest_px;
}

/// Why a place is rejected that vision cannot locate.
constexpr char kUnseen[] = "a lamp's ray does not meet the plane";

/// Returns a place as vision locates it; empty when a lamp's ray does not meet the plane.
std::optional<PairRow> seen_row(const Workplane& workplane, const ToolOffsets& tool,
                                const PoseSight& sight) {
  const auto seen = tip_from_lamps(workplane, tool, sight);
  if (!seen) return std::nullopt;
  PairRow row;
  row.id = sight.id;
  row.plan = sight.plan;
  row.theta = sight.theta;
  row.t_s = sight.t_s;
  row.p_vision = seen->tip.p;
  row.phi = seen->tip.phi;
  row.lamps_B = seen->lamps_B;
  row.sigma_vision = per_axis(seen->covariance);
  return row;
}

/// Adds a row for each pose that no tracker watched, unless the plane's fit has left it out or a
/// lamp's ray does not meet the plane.
void add_unattended(const Workplane& workplane, const WorkplaneFit& fit,
                    const std::vector<PoseSight>& poses, PairTrackerReport& report) {
  for (const PoseSight& sight : poses) {
    const auto is_this = [&](const Rejection& rejection) { return rejection.id == sight.id; };
    if (std::any_of(fit.rejected.begin(), fit.rejected.end(), is_this)) continue;
    if (auto row = seen_row(workplane, fit.tool, sight))
      report.pairs.push_back(std::move(*row));
    else
      report.rejected.push_back({sight.id, kUnseen});
  }
}

bool has_tool_readings(const PairTrackerRequest& request) {
  return std::any_of(request.tracker.begin(), request.tracker.end(), [&](const TrackerRow& row) {
    return std::none_of(request.cell.datum.begin(), request.cell.datum.end(),
                        [&](const Monument& monument) { return monument.id == row.id; });
  });
}

WorkplaneFit fit_to_arm(const PairTrackerRequest& request, const std::vector<PoseSight>& poses) {
  const PlanarArm arm(request.cell.arm.geometry);
  const auto sent = each(poses, [&](const PoseSight& pose) {
    return SentSight{pose, arm.forward(pose.theta).p};
  });
  return fit_workplane_to_arm(request.camera, each(request.boards_on_plane, &LaidBoard::X_CG), sent,
                              request.dots_height);
}

struct SortedReadings {
  std::vector<MonumentReading> begin, end;  ///< of monuments: for the datum, and read once more
  std::vector<TrackerRow> tool;
};

/// Says what the readings are called where none is called as a monument.
Refusal no_monument(const PairTrackerRequest& request) {
  constexpr std::size_t kShown = 8;
  std::set<std::string> monuments, readings;
  for (const Monument& monument : request.cell.datum) monuments.insert(monument.id);
  for (const TrackerRow& row : request.tracker)
    if (readings.size() < kShown) readings.insert(row.id);
  return {fmt::format("no reading has the name of a monument ({}); they are called {}, ...",
                      fmt::join(monuments, ", "), fmt::join(readings, ", ")),
          "name the monuments in `datum` of the cell file as the tracker does", "tracker",
          Cause::kMissing};
}

SortedReadings sort_readings(const PairTrackerRequest& request) {
  std::set<std::string> ids;
  std::map<std::string, std::size_t> first_after;  ///< by monument, so many readings of the tool
  for (const Monument& monument : request.cell.datum) ids.insert(monument.id);
  SortedReadings sorted;
  for (const TrackerRow& row : request.tracker) {
    if (ids.count(row.id) == 0) {
      sorted.tool.push_back(row);
      continue;
    }
    const MonumentReading reading{row.id, row.p_L, request.cell.tracker.sigma_at(row.p_L.norm())};
    const auto first = first_after.try_emplace(row.id, sorted.tool.size()).first;
    (first->second == sorted.tool.size() ? sorted.begin : sorted.end).push_back(reading);
  }
  if (first_after.empty()) throw InputError(no_monument(request));
  return sorted;
}

void add_doubt(const Refusal& doubt, PairTrackerReport& report) {
  if (!doubt.fault.empty()) report.doubts.push_back(doubt);
}

void reject(const std::vector<Rejection>& rejected, PairTrackerReport& report) {
  report.rejected.insert(report.rejected.end(), rejected.begin(), rejected.end());
}

/// Registers the tracker by all readings of the monuments, or by the first ones when the last ones
/// differ, and says what moved. Throws when the last ones differ by far.
DatumRegistration registered(const std::vector<Monument>& datum, const SortedReadings& readings,
                             PairTrackerReport& report) {
  DatumRegistration registration = register_datum(datum, readings.begin);
  if (registration.left_out)
    report.rejected.push_back({*registration.left_out, registration.doubt.text()});
  add_doubt(registration.doubt, report);
  const MonumentVerdict drift =
      check_drift(monument_sights(datum, readings.begin), monument_sights(datum, readings.end));
  if (drift.refused) throw InputError(drift.doubt);
  add_doubt(drift.doubt, report);
  if (readings.end.empty() || !drift.doubt.fault.empty()) return registration;
  std::vector<MonumentReading> both = readings.begin;
  both.insert(both.end(), readings.end.begin(), readings.end.end());
  return register_datum(datum, both);
}

/// Doubts readings that scatter more than stated, and replaces the stated deviation by their own.
PairTrackerRequest with_tracker_as_it_scatters(PairTrackerRequest request,
                                               PairTrackerReport& report) {
  const RestSpread spread = rest_spread(request.cell, request.tracker, request.by);
  if (!spread.is_shaking()) return request;
  report.doubts.push_back(spread.doubt());
  request.cell.tracker.sigma_m *= spread.rms / spread.stated;
  request.cell.tracker.sigma_m_per_m *= spread.rms / spread.stated;
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
        {fmt::format("tracker: it was frozen at {} places, '{}' first, where its reading did not "
                     "change while the lamps moved; they are left out",
                     frozen.size(), frozen.front().id),
         "record them again"});
  require_reading_order(pairing.sights, request.by);
  return pairing;
}

WorkplaneFit fit_workplane(const PairTrackerRequest& request,
                           const std::vector<ToolSight>& sights) {
  std::vector<ToolSight> fitted;
  std::copy_if(sights.begin(), sights.end(), std::back_inserter(fitted),
               [](const ToolSight& sight) {
                 return sight.plan == Purpose::kTrain || sight.plan == Purpose::kSweep1 ||
                        sight.plan == Purpose::kSweep3;
               });
  return request.boards_on_plane.empty()
             ? fit_workplane_to_pairs(request.camera, fitted)
             : fit_workplane_to_board(request.camera,
                                      each(request.boards_on_plane, &LaidBoard::X_CG), fitted,
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

/// Doubts readings that scatter more than stated, and gives them their own deviation.
void look_for_scatter(const std::vector<PairRow>& in_time, PairTrackerReport& report) {
  const auto scatter = find_scatter(in_time);
  if (!scatter) return;
  report.doubts.push_back(scatter->doubt());
  for (PairRow& row : report.pairs)
    if (row.sigma_tracker) *row.sigma_tracker *= scatter->found / scatter->stated;
}

/// Doubts pairs between which something moved, suddenly or slowly; throws when that would cost too
/// much. Places that the plane's fit has left out are included, because after a step near the end
/// of a recording they may be most of those that show it.
void look_for_motion(const PairTrackerRequest& request, const std::vector<PairRow>& in_time,
                     PairTrackerReport& report) {
  const auto doubt = [&](const auto& motion) {
    if (motion.needs_consent() && !request.accept_step) throw InputError(motion.doubt());
    report.doubts.push_back(motion.doubt());
  };
  report.step = find_step(in_time);
  if (report.step) return doubt(*report.step);
  report.trend = find_trend(in_time);
  if (report.trend) doubt(*report.trend);
}

/// Logs what was decided, for --verbose.
void log(const PairTrackerReport& report) {
  if (report.datum)
    for (const MonumentResidual& monument : report.datum->residuals)
      spdlog::debug(fmt::format("monument {}: {:.4f} mm off in {} readings", monument.id,
                                mm(monument.residual_B.norm()), monument.readings));
  spdlog::debug(fmt::format("the workplane is fitted to {} places", report.workplane.n_used));
  for (const Refusal& doubt : report.doubts) spdlog::warn(doubt.text());
  for (const Rejection& rejection : report.rejected)
    spdlog::debug(fmt::format("left out {}: {}", rejection.id, rejection.reason));
}

/// Makes the pairs of a recording that no tracker watched.
PairTrackerReport pair_without_tracker(const PairTrackerRequest& request) {
  if (request.boards_on_plane.empty())
    throw InputError({"there is no reading of the tool",
                      "without a tracker the plane must come from a board that was laid on it, "
                      "with --workplane-from grid --grid circles:COLSxROWS:PITCHmm",
                      "tracker", Cause::kMissing});
  PairTrackerReport report;
  Pairing places = unattended_sights(lamp_sights(request.lamps, request.frames));
  report.workplane = fit_to_arm(request, places.unattended);
  report.largest_eccentricity_px =
      remove_eccentricity(Workplane(request.camera, report.workplane.X_WC),
                          request.cell.lamps.layout.diameters_m, places.unattended);
  report.workplane = fit_to_arm(request, places.unattended);
  reject(places.rejected, report);
  reject(report.workplane.rejected, report);
  add_unattended(Workplane(request.camera, report.workplane.X_WC), report.workplane,
                 places.unattended, report);
  require_lamps_in_order(request.cell, request.frames, report.pairs);
  log(report);
  return report;
}

}  // namespace

std::vector<LampSight> lamp_sights(const std::vector<LampRow>& lamps,
                                   const std::vector<FrameRow>& frames) {
  std::map<std::string, const FrameRow*> by_image, by_id;
  for (const FrameRow& frame : frames) {
    by_image.emplace(frame.image, &frame);
    by_id.emplace(frame.id, &frame);
  }
  Faults faults;
  std::vector<LampSight> sights;
  for (const LampRow& row : lamps) {
    const auto& index = row.image.empty() ? by_id : by_image;
    const auto found = index.find(row.image.empty() ? row.id : row.image);
    if (found == index.end() || found->second->id != row.id) {
      faults.add({fmt::format("id '{}', image '{}' is not in the recording's frames.csv", row.id,
                              row.image),
                  "", "lamps", Cause::kMissing});
      continue;
    }
    const FrameRow& frame = *found->second;
    if (shows_board(frame.plan)) continue;
    LampSight sight{{{}, row.id, frame.plan, frame.theta}, ""};
    if (row.status != LampStatus::kOk)
      sight.fault = name(row.status);
    else if (row.uv_px.size() != 2)
      sight.fault = name(LampStatus::kOneLamp);
    else
      static_cast<Observation&>(sight) = observation_of(row);
    sight.t_s = frame.t_s;
    sights.push_back(std::move(sight));
  }
  faults.throw_if_any();
  return sights;
}

PairTrackerReport pair_tracker(const PairTrackerRequest& asked) {
  if (!has_tool_readings(asked)) return pair_without_tracker(asked);
  PairTrackerReport report;
  const PairTrackerRequest request = with_tracker_as_it_scatters(asked, report);
  const SortedReadings readings = sort_readings(request);
  const DatumRegistration datum = registered(request.cell.datum, readings, report);
  report.datum = datum;
  std::vector<ToolReading> tool_readings;
  for (const TrackerRow& row : readings.tool)
    tool_readings.push_back(
        {row.id, row.t_s, datum.X_BL * row.p_L, request.cell.tracker.sigma_at(row.p_L.norm())});
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

Summary raw_error(const std::vector<PairRow>& pairs, std::optional<Purpose> plan) {
  std::vector<double> lengths;
  for (const PairRow& pair : pairs)
    if (pair.is_attended() && (!plan || pair.plan == plan)) lengths.push_back(pair.error().norm());
  return summarize(lengths);
}

}  // namespace planar
