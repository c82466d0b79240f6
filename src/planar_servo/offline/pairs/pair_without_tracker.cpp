#include "planar_servo/offline/pairs/pair_without_tracker.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/calibration/workplane_by_arm.h"
#include "planar_servo/core/error.h"
#include "planar_servo/offline/pairs/lamp_places.h"
#include "planar_servo/offline/pairs/recording_check.h"

namespace planar {
namespace {

WorkplaneFit fit_to_arm(const PairTrackerRequest& request, const std::vector<PoseSight>& poses) {
  const PlanarArm arm(request.cell.arm.geometry);
  std::vector<SentSight> sent;
  sent.reserve(poses.size());
  for (const PoseSight& pose : poses) sent.push_back({pose, arm.forward(pose.theta).p});
  return fit_workplane_to_arm(request.camera, poses_of(request.boards_on_plane), sent,
                              request.dots_height);
}

bool is_left_out(const WorkplaneFit& fit, const std::string& id) {
  return std::any_of(fit.rejected.begin(), fit.rejected.end(),
                     [&](const Rejection& rejection) { return rejection.id == id; });
}

}  // namespace

bool has_tool_readings(const PairTrackerRequest& request) {
  return std::any_of(request.tracker.begin(), request.tracker.end(), [&](const TrackerRow& row) {
    return std::none_of(request.cell.datum.begin(), request.cell.datum.end(),
                        [&](const Monument& monument) { return monument.id == row.id; });
  });
}

void add_unattended(const Workplane& workplane, const WorkplaneFit& fit,
                    const std::vector<PoseSight>& poses, PairTrackerReport& report) {
  for (const PoseSight& sight : poses) {
    if (is_left_out(fit, sight.id)) continue;
    if (auto row = seen_row(workplane, fit.tool, sight))
      report.pairs.push_back(std::move(*row));
    else
      report.rejected.push_back({sight.id, kUnseen});
  }
}

PairTrackerReport pair_without_tracker(const PairTrackerRequest& request) {
  if (request.boards_on_plane.empty())
    throw InputError(
        "tracker: there is no reading of the tool; without a tracker the plane must come from a "
        "board that was laid on it, with --workplane-from grid --grid circles:COLSxROWS:PITCHmm");
  PairTrackerReport report;
  Pairing places = unattended_sights(lamp_sights(request.lamps, request.frames));
  report.workplane = fit_to_arm(request, places.unattended);
  report.largest_eccentricity_px =
      remove_eccentricity(Workplane(request.camera, report.workplane.X_WC),
                          request.cell.lamps.layout.diameters_m, places.unattended);
  report.workplane = fit_to_arm(request, places.unattended);
  report.rejected = std::move(places.rejected);
  report.rejected.insert(report.rejected.end(), report.workplane.rejected.begin(),
                         report.workplane.rejected.end());
  add_unattended(Workplane(request.camera, report.workplane.X_WC), report.workplane,
                 places.unattended, report);
  require_lamps_in_order(request.cell, request.frames, report.pairs);
  for (const Rejection& rejection : report.rejected)
    spdlog::debug(fmt::format("left out {}: {}", rejection.id, rejection.reason));
  return report;
}

}  // namespace planar
