#include "app/lamp_prediction.h"

#include <filesystem>

#include "calibration/vision_tip.h"
#include "files/camera_file.h"
#include "files/tool_file.h"
#include "files/workplane_file.h"

namespace planar {
namespace {

constexpr double kCoarseShare = 0.10;  // without a lens model, good to several per cent

}  // namespace

PairExpectation expect_lamps(const std::array<Eigen::Vector2d, 2>& predicted_px, double share) {
  const double distance = (predicted_px[1] - predicted_px[0]).norm();
  return {predicted_px, {{distance * (1.0 - share), distance * (1.0 + share)}}};
}

LampScene lamp_scene(const CellSettings& cell) {
  namespace fs = std::filesystem;
  LampScene scene;
  scene.sensor_px = {cell.camera.width_px, cell.camera.height_px};
  scene.separation_m = cell.lamp_separation_m;
  if (fs::exists(cell.camera_model) && fs::exists(cell.workplane)) {
    scene.workplane.emplace(read_camera(cell.camera_model).camera,
                            read_workplane(cell.workplane).X_WC);
    if (fs::exists(cell.tool)) scene.tool = read_tool(cell.tool);
  }
  return scene;
}

LampPrediction::LampPrediction(const LampScene& scene, std::optional<CoarseView> view)
    : scene_(scene), view_(std::move(view)) {}

std::optional<std::array<Eigen::Vector2d, 2>> LampPrediction::lamps_px(const TipPose& tip) const {
  if (scene_.workplane) {
    return lamps_from_tip(*scene_.workplane, scene_.tool, scene_.separation_m, tip);
  }
  if (!view_) return std::nullopt;
  const Eigen::Vector2d half =
      rotation2d(tip.phi) * Eigen::Vector2d(scene_.separation_m / 2.0, 0.0);
  const auto first = view_->pixel(tip.p - half), second = view_->pixel(tip.p + half);
  if (!first || !second) return std::nullopt;
  return std::array<Eigen::Vector2d, 2>{*first, *second};
}

PairExpectation LampPrediction::of(const LampImage& image) const {
  if (!image.commanded) return {};
  const auto predicted_px = lamps_px(*image.commanded);
  if (!predicted_px) return {};
  return expect_lamps(*predicted_px, scene_.workplane ? kCalibratedShare : kCoarseShare);
}

}  // namespace planar
