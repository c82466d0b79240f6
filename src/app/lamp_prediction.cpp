#include "app/lamp_prediction.h"

#include <filesystem>

#include "calibration/vision_tip.h"
#include "files/camera_file.h"
#include "files/tool_file.h"
#include "files/workplane_file.h"

namespace planar {
namespace {

// Share by which the pair's distance in pixels may differ from the prediction: a calibrated plane
// is good to a per cent or two, a map without a lens model to several.
constexpr double kCalibratedShare = 0.03;
constexpr double kCoarseShare = 0.10;

}  // namespace

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
  PairExpectation expectation;
  if (!image.commanded) return expectation;
  expectation.predicted_px = lamps_px(*image.commanded);
  if (!expectation.predicted_px) return expectation;
  const auto& [first, second] = *expectation.predicted_px;
  const double distance = (second - first).norm();
  const double share = scene_.workplane ? kCalibratedShare : kCoarseShare;
  expectation.separation_px = {distance * (1.0 - share), distance * (1.0 + share)};
  return expectation;
}

}  // namespace planar
