#include "planar_servo/vision/lamp_tip_sensor.h"

#include <cmath>

#include "planar_servo/calibration/vision_tip.h"
#include "planar_servo/core/error.h"
#include "planar_servo/files/camera/camera_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/files/workplane_file.h"
#include "planar_servo/vision/regions.h"

namespace planar {
namespace {

TipMeasurement failed(const std::string& status, double t_s) {
  TipMeasurement measurement;
  measurement.status = status;
  measurement.t_s = t_s;
  return measurement;
}

/// Names every file that is missing, with the program that makes it.
void require_files(const CellSettings& cell, bool with_error_map) {
  Faults faults;
  const auto require = [&](const std::filesystem::path& path, const std::string& program) {
    try {
      require_made(path, program);
    } catch (const InputError& e) {
      faults.add(e.what());
    }
  };
  require(cell.camera_model, "planar-calibrate-camera");
  require(cell.workplane, "planar-pair-tracker");
  require(cell.tool, "planar-pair-tracker");
  if (with_error_map) require(cell.error_map, "planar-fit-error-map");
  faults.throw_if_any();
}

}  // namespace

VisionCalibration read_vision(const CellSettings& cell, bool with_error_map) {
  require_files(cell, with_error_map);
  VisionCalibration vision{
      Workplane(read_camera(cell.camera_model).camera, read_workplane(cell.workplane).X_WC),
      read_tool(cell.tool), std::nullopt};
  if (with_error_map) vision.error_map = read_map(cell.error_map);
  return vision;
}

LampTipSensor::LampTipSensor(const CellSettings& cell, VisionCalibration vision,
                             CenterMethod method, FrameSource& camera)
    : camera_settings_(cell.camera),
      lamps_(lamp_layout(cell)),
      vision_(std::move(vision)),
      tracker_(method),
      camera_(camera) {}

void LampTipSensor::aim(const TipPose& expected) {
  if (const auto predicted = lamps_at(expected)) aim_at(*predicted);
}

void LampTipSensor::aim_at(const std::array<Eigen::Vector2d, 2>& lamps_px) {
  camera_.set_region(follow_region(camera_settings_, 0.5 * (lamps_px[0] + lamps_px[1])));
}

TipMeasurement LampTipSensor::measure(const TipPose& expected, int frames) {
  const auto predicted = lamps_at(expected);
  if (!predicted) return failed("outside_view", 0.0);
  const PairExpectation expectation = expect_lamps(lamps_, *predicted, kCalibratedShare);
  aim_at(*predicted);
  TipMeasurement mean;
  mean.lamps_px.fill(Eigen::Vector2d::Zero());
  std::array<Eigen::Matrix2d, 2> covariances{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  for (int i = 0; i < frames; ++i) {
    const Sight sight =
        look(i == 0 ? camera_.next_frame() : camera_.following_frame(), expectation);
    if (sight.frame != FrameStatus::kOk) {
      TipMeasurement blind = failed(name(sight.frame), sight.t_s);
      blind.blind = true;
      return blind;
    }
    if (sight.pair.status != LampStatus::kOk) return failed(name(sight.pair.status), sight.t_s);
    mean.t_s = sight.t_s;
    for (std::size_t k = 0; k < 2; ++k) {
      mean.lamps_px[k] += sight.pair.lamps[k].uv_px / frames;
      covariances[k] += sight.pair.lamps[k].covariance_px2 / frames;
    }
  }
  mean.frames = frames;
  return position(std::move(mean), covariances);
}

std::optional<std::array<Eigen::Vector2d, 2>> LampTipSensor::lamps_at(const TipPose& tip) const {
  return lamps_from_tip(vision_.workplane, vision_.tool, lamps_.separation_m, tip);
}

LampTipSensor::Sight LampTipSensor::look_at(const FrameResult& result,
                                            const PairExpectation& expectation) {
  if (result.status != FrameStatus::kOk) return {{}, result.frame.t_s, result.status};
  last_frame_ = result.frame;
  return {tracker_.locate(last_frame_, expectation), last_frame_.t_s, FrameStatus::kOk};
}

LampTipSensor::Sight LampTipSensor::look(const FrameResult& result,
                                         const PairExpectation& expectation) {
  Sight sight = look_at(result, expectation);
  const cv::Size sensor = camera_.sensor_size_px();
  if (sight.frame != FrameStatus::kOk || sight.pair.status == LampStatus::kOk ||
      last_frame_.region_px.size() == sensor)
    return sight;
  camera_.set_region({0, 0, sensor.width, sensor.height});
  sight = look_at(camera_.next_frame(), expectation);
  if (sight.frame == FrameStatus::kOk && sight.pair.status == LampStatus::kOk)
    aim_at({sight.pair.lamps[0].uv_px, sight.pair.lamps[1].uv_px});
  return sight;
}

TipMeasurement LampTipSensor::position(
    TipMeasurement measurement, const std::array<Eigen::Matrix2d, 2>& covariances_px2) const {
  const auto& discs_px = measurement.lamps_px;
  const auto shifts_px = lamp_eccentricities_px(vision_.workplane, discs_px, lamps_.diameters_m);
  const auto seen =
      tip_from_lamps(vision_.workplane, vision_.tool,
                     {discs_px[0] - shifts_px[0], discs_px[1] - shifts_px[1]}, covariances_px2);
  if (!seen) return failed("outside_view", measurement.t_s);
  measurement.p_vision = seen->tip.p;
  measurement.tip = seen->tip;
  measurement.sigma_vision_m = std::sqrt(0.5 * seen->covariance.trace());
  const double vision_variance =
      measurement.sigma_vision_m * measurement.sigma_vision_m / measurement.frames;
  double map_variance = 0.0;
  if (vision_.error_map) {
    const ErrorPrediction prediction =
        predict(*vision_.error_map, measurement.p_vision, seen->tip.phi);
    measurement.correction = prediction.error;
    measurement.inside_map = prediction.inside;
    map_variance = prediction.sigma * prediction.sigma;
  }
  measurement.tip.p = measurement.p_vision - measurement.correction;
  measurement.uncertainty_m = std::sqrt(map_variance + vision_variance);
  return measurement;
}

}  // namespace planar
