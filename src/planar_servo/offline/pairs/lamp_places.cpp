#include "planar_servo/offline/pairs/lamp_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "planar_servo/core/error.h"

namespace planar {

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

}  // namespace planar
