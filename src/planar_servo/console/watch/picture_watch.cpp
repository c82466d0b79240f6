#include "planar_servo/console/watch/picture_watch.h"

#include <algorithm>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/jog/lamp_finder.h"
#include "planar_servo/vision/reference_lamps.h"

namespace planar {
namespace {

constexpr double kWhite = 255.0;
constexpr double kExamineFrameEvery_s = 0.15;

std::array<LampState, 2> lamp_states(const SightedLamps& sight) {
  std::array<LampState, 2> states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const LampCenter& lamp = sight.lamps[i];
    states[i] = {lamp.uv_px, sight.edges_px[i], lamp.look.level >= kWhite};
  }
  return states;
}

}  // namespace

PictureWatch::PictureWatch(const CellSettings& cell, const std::optional<VisionCalibration>& vision,
                           StateBoard& board)
    : board_(board),
      pictures_({cell.camera.width_px, cell.camera.height_px}),
      method_(cell.lamps.method) {
  if (vision) fixed_ = vision->reference_lamps;
}

void PictureWatch::take(const Frame& frame, bool is_watched) {
  const std::uint64_t number = pictures_.take(frame);
  board_.change([&](CellState& state) {
    state.picture = number;
    state.picture_s = clock_.now_s();
  });
  if (!is_watched || clock_.now_s() - examined_s_ < kExamineFrameEvery_s) return;
  examined_s_ = clock_.now_s();
  examine(frame);
}

void PictureWatch::examine(const Frame& frame) {
  const auto sight = sight_lamps(frame, places_px(fixed_), lamps_px_);
  lamps_px_.reset();
  if (sight) {
    lamps_px_ = LampPixels{sight->lamps[0].uv_px, sight->lamps[1].uv_px};
    pictures_.aim(*lamps_px_);
    best_px_ = std::min(sight->mean_edge_px(), best_px_.value_or(sight->mean_edge_px()));
  }
  const bool is_whole = frame.region_px.size() == pictures_.sensor_px();
  auto fixed = is_whole ? fixed_lamps(frame) : std::vector<FixedLampState>();
  board_.change([&](CellState& state) {
    state.lamps.reset();
    state.edge_px.reset();
    state.best_edge_px = best_px_;
    if (sight) {
      state.lamps = lamp_states(*sight);
      state.edge_px = sight->mean_edge_px();
    }
    if (is_whole) state.fixed_lamps = std::move(fixed);
  });
}

std::vector<FixedLampState> PictureWatch::fixed_lamps(const Frame& frame) {
  std::vector<FixedLampState> states;
  for (const ReferenceLamp& lamp : fixed_)
    if (const auto seen = find_fixed_light(frame, lamp.uv_px, detector_, method_))
      states.push_back({lamp.id, seen->uv_px, (seen->uv_px - lamp.uv_px).norm()});
  return states;
}

}  // namespace planar
