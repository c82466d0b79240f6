#include "planar_servo/vision/lamp_prediction.h"

#include <filesystem>

#include "planar_servo/calibration/vision_tip.h"
#include "planar_servo/files/camera/camera_file.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/files/workplane_file.h"

namespace planar {
namespace {

constexpr double kCoarseShare = 0.10;  // without a lens model, good to several per cent

}  // namespace

LampLayout lamp_layout(const CellSettings& cell) {
  return {cell.lamp_separation_m, cell.lamp_diameters_m};
}

PairExpectation expect_lamps(const LampLayout& layout,
                             const std::array<Eigen::Vector2d, 2>& predicted_px, double share) {
  const double distance = (predicted_px[1] - predicted_px[0]).norm();
  PairExpectation expectation;
  expectation.predicted_px = predicted_px;
  expectation.separation_px = {distance * (1.0 - share), distance * (1.0 + share)};
  expectation.diameter_over_separation = layout.diameter_over_separation();
  return expectation;
}

LampScene lamp_scene(const CellSettings& cell) {
  namespace fs = std::filesystem;
  LampScene scene;
  scene.sensor_px = {cell.camera.width_px, cell.camera.height_px};
  scene.lamps = lamp_layout(cell);
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
    return lamps_from_tip(*scene_.workplane, scene_.tool, scene_.lamps.separation_m, tip);
  }
  if (!view_) return std::nullopt;
  const Eigen::Vector2d half =
      rotation2d(tip.phi) * Eigen::Vector2d(scene_.lamps.separation_m / 2.0, 0.0);
  const auto first = view_->pixel(tip.p - half), second = view_->pixel(tip.p + half);
  if (!first || !second) return std::nullopt;
  return std::array<Eigen::Vector2d, 2>{*first, *second};
}

PairExpectation LampPrediction::of(const std::optional<TipPose>& commanded) const {
  const auto predicted_px = commanded ? lamps_px(*commanded) : std::nullopt;
  if (predicted_px) {
    return expect_lamps(scene_.lamps, *predicted_px,
                        scene_.workplane ? kCalibratedShare : kCoarseShare);
  }
  PairExpectation expectation;
  expectation.diameter_over_separation = scene_.lamps.diameter_over_separation();
  return expectation;
}

}  // namespace planar
