#include "planar_servo/offline/pairs/health_of_recording.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

/// The lamps of one place, averaged over its frames.
struct MeanSight {
  const FrameRow* frame{nullptr};
  std::array<Eigen::Vector2d, 2> uv_px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<Eigen::Matrix2d, 2> covariances_px2{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  double count{0.0};

  void add(const LampRow& row) {
    for (std::size_t k = 0; k < 2; ++k) {
      uv_px[k] += row.uv_px[k];
      covariances_px2[k] += row.covariance_px2[k];
    }
    count += 1.0;
  }
  void finish() {
    for (std::size_t k = 0; k < 2; ++k) {
      uv_px[k] /= count;
      covariances_px2[k] /= count * count;
    }
  }
};

std::map<std::string, MeanSight> mean_sights(const std::vector<FrameRow>& frames,
                                             const std::vector<LampRow>& lamps) {
  std::map<std::string, const FrameRow*> by_image;
  for (const FrameRow& frame : frames)
    if (!shows_board(frame.plan)) by_image.emplace(frame.image, &frame);
  std::map<std::string, MeanSight> sights;
  for (const LampRow& row : lamps) {
    const auto frame = by_image.find(row.image);
    if (frame == by_image.end() || row.status != LampStatus::kOk || row.uv_px.size() != 2) continue;
    MeanSight& sight = sights[row.id];
    sight.frame = frame->second;
    sight.add(row);
  }
  for (auto& [id, sight] : sights) sight.finish();
  return sights;
}

}  // namespace

HealthRecord health_of_recording(const CellSettings& cell, const VisionCalibration& vision,
                                 const std::vector<FrameRow>& frames,
                                 const std::vector<LampRow>& lamps) {
  const PlanarArm arm(cell.arm.geometry);
  std::vector<SeenPlace> seen;
  for (const auto& [id, sight] : mean_sights(frames, lamps)) {
    const auto place = place_tool(vision, sight.uv_px, sight.covariances_px2);
    if (!place) continue;
    const double sigma_m = std::sqrt(0.5 * place->covariance.trace());
    seen.push_back({{id, sight.frame->theta, place->lamps_B, sigma_m},
                    arm.forward(sight.frame->theta),
                    place->seen});
  }
  if (seen.size() < kHealthPlaces)
    throw InputError(
        fmt::format("the recording has {} places with both lamps; a check of the cell's health "
                    "needs {} of them to visit again",
                    seen.size(), kHealthPlaces));
  return health_record_of(seen);
}

}  // namespace planar
