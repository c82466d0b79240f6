#include "planar_servo/offline/pairs/pair_tracker.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <set>

#include "planar_servo/calibration/readings/reading_order.h"
#include "planar_servo/calibration/vision_tip.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/lens/workplane.h"
#include "planar_servo/offline/pairs/recording_check.h"

namespace planar {
namespace {

bool serves_fit(Plan plan) {
  return plan == Plan::kTrain || plan == Plan::kSweep1 || plan == Plan::kSweep3;
}

/// Joins the lamps' rows with what the recording knows of their frames. Views of boards are left
/// out.
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
      faults.add(fmt::format("lamps: id '{}', image '{}' is not in the recording's frames.csv",
                             row.id, row.image));
      continue;
    }
    const FrameRow& frame = *found->second;
    if (shows_board(frame.plan)) continue;
    LampSight sight;
    sight.id = row.id;
    sight.t_s = frame.t_s;
    sight.plan = frame.plan;
    sight.theta = frame.theta;
    if (row.status != LampStatus::kOk) {
      sight.fault = name(row.status);
    } else if (row.uv_px.size() != 2) {
      sight.fault = name(LampStatus::kOneLamp);
    } else {
      std::copy(row.uv_px.begin(), row.uv_px.end(), sight.uv_px.begin());
      std::copy(row.covariance_px2.begin(), row.covariance_px2.end(),
                sight.covariances_px2.begin());
    }
    sights.push_back(std::move(sight));
  }
  faults.throw_if_any();
  return sights;
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

/// Registers the tracker, and says what moved.
DatumRegistration registered(const std::vector<Monument>& datum, const SortedReadings& readings,
                             PairTrackerReport& report) {
  DatumRegistration registration = register_datum(datum, readings.begin);
  if (registration.left_out)
    report.rejected.push_back({*registration.left_out, registration.doubt});
  add_doubt(registration.doubt, report);
  add_doubt(doubt_of_drift(datum, readings), report);
  return registration;
}

/// Pairs frames and readings and takes out those of a frozen tracker.
Pairing paired(const PairTrackerRequest& request, const std::vector<ToolReading>& readings,
               PairTrackerReport& report) {
  const std::vector<LampSight> frames = lamp_sights(request.lamps, request.frames);
  Pairing pairing = pair_sights(frames, readings, request.by);
  reject(pairing.rejected, report);
  const std::vector<Rejection> frozen = take_out_frozen(pairing.sights);
  reject(frozen, report);
  if (!frozen.empty())
    report.doubts.push_back(
        fmt::format("tracker: it was frozen at {} places, '{}' first, where its reading did not "
                    "change while the "
                    "lamps moved; they are left out; record them again",
                    frozen.size(), frozen.front().id));
  require_reading_order(pairing.sights, frames, readings, request.by);
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

/// Moves the lamps' places from the centres of their images to the images of their centres. Returns
/// the largest shift, pixels.
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

/// Returns what vision says of a place; empty when a lamp's ray does not meet the plane.
std::optional<PairRow> seen_row(const Workplane& workplane, const ToolOffsets& tool,
                                const PoseSight& sight) {
  const auto seen = tip_from_lamps(workplane, tool, sight.lamps_px, sight.covariances_px2);
  if (!seen) return std::nullopt;
  PairRow row;
  row.id = sight.id;
  row.plan = sight.plan;
  row.theta = sight.theta;
  row.t_s = sight.t_s;
  row.p_vision = seen->tip.p;
  row.phi = seen->tip.phi;
  row.lamps_B = seen->lamps_B;
  row.sigma_vision = std::sqrt(0.5 * seen->covariance.trace());
  return row;
}

/// Adds a row for each place that the plane's fit has not left out: the attended ones, then the
/// unattended.
void add_rows(const Pairing& places, const Workplane& workplane, const WorkplaneFit& fit,
              PairTrackerReport& report) {
  const std::string unseen = "a lamp's ray does not meet the plane";
  std::set<std::string> outliers;
  for (const Rejection& rejection : fit.rejected) outliers.insert(rejection.id);
  for (const ToolSight& sight : places.sights) {
    if (outliers.count(sight.id) != 0) continue;
    auto row = seen_row(workplane, fit.tool, sight);
    if (!row) {
      report.rejected.push_back({sight.id, unseen});
      continue;
    }
    row->p_tracker = end_point_by_tracker(fit.tool, sight, *row->phi);
    row->p_reflector = sight.p_reflector_B.head<2>();
    row->sigma_tracker = sight.sigma_tracker;
    report.pairs.push_back(std::move(*row));
  }
  for (const PoseSight& sight : places.unattended) {
    auto row = seen_row(workplane, fit.tool, sight);
    if (row)
      report.pairs.push_back(std::move(*row));
    else
      report.rejected.push_back({sight.id, unseen});
  }
}

/// Tells who asks for it what was decided.
void log(const PairTrackerReport& report) {
  for (const MonumentResidual& monument : report.datum.residuals)
    spdlog::debug(fmt::format("monument {}: {:.4f} mm off in {} readings", monument.id,
                              monument.residual_B.norm() / kMillimetre, monument.readings));
  spdlog::debug(fmt::format("the workplane is fitted to {} places", report.workplane.n_used));
  for (const std::string& doubt : report.doubts) spdlog::warn(doubt);
  for (const Rejection& rejection : report.rejected)
    spdlog::debug(fmt::format("left out {}: {}", rejection.id, rejection.reason));
}

}  // namespace

PairTrackerReport pair_tracker(const PairTrackerRequest& request) {
  PairTrackerReport report;
  const SortedReadings readings = sort_readings(request);
  report.datum = registered(request.cell.datum, readings, report);
  std::vector<ToolReading> tool_readings;
  for (const TrackerRow& row : readings.tool) {
    tool_readings.push_back({row.id, row.t_s, report.datum.X_BL * row.p_L,
                             request.cell.tracker.sigma_at(row.p_L.norm())});
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
  add_rows(places, Workplane(request.camera, report.workplane.X_WC), report.workplane, report);
  require_upright_tracker(report.datum, report.workplane.tool);
  require_lamps_in_order(request.cell, request.frames, report.pairs);
  add_doubt(doubt_of_change(report.pairs), report);
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
