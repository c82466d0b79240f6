#include "planar_servo/geometry/lens/camera_model.h"

#include <algorithm>

#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/lens/lens_models.h"

namespace planar {

void lens::check_camera(const char* lens_model, const Intrinsics& k,
                        const std::vector<double>& coefficients, std::size_t most_coefficients) {
  if (coefficients.size() > most_coefficients)
    throw InputError(std::string("lens model ") + lens_model + " has " +
                     std::to_string(most_coefficients) + " coefficients, not " +
                     std::to_string(coefficients.size()));
  std::vector<double> numbers{k.fx, k.fy, k.cx, k.cy};
  numbers.insert(numbers.end(), coefficients.begin(), coefficients.end());
  const auto is_finite = [](double v) { return std::isfinite(v); };
  if (!std::all_of(numbers.begin(), numbers.end(), is_finite) || k.fx <= 0.0 || k.fy <= 0.0)
    throw InputError("a focal length is not positive or a number of the camera is not finite");
}

void lens::refuse_camera(const char* beyond) {
  throw InputError(std::string("camera with ") + beyond);
}

CameraModel::CameraModel() : CameraModel(Pinhole{}) {}

Intrinsics intrinsics(const CameraModel& camera) {
  return camera.lens().k();
}

std::vector<double> distortion_coefficients(const CameraModel& camera) {
  return camera.lens().coefficients();
}

std::string lens_model_name(const CameraModel& camera) {
  return camera.lens().name();
}

CameraModel moved_camera(const CameraModel& camera, const Eigen::VectorXd& step) {
  Intrinsics k = intrinsics(camera);
  k.fx += step[0];
  k.fy += step[1];
  k.cx += step[2];
  k.cy += step[3];
  std::vector<double> coefficients = distortion_coefficients(camera);
  for (Eigen::Index i = 4; i < step.size(); ++i) coefficients[i - 4] += step[i];
  return camera.lens().with(k, coefficients);
}

std::optional<Eigen::Vector2d> project(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                       Eigen::Matrix<double, 2, 3>* d_uv_d_p) {
  if (!p_C.allFinite() || p_C.z() <= 0.0) return std::nullopt;
  const Eigen::Vector2d xy = p_C.head<2>() / p_C.z();
  if (!xy.allFinite()) return std::nullopt;
  const auto distorted = camera.lens().distort(xy);
  if (!distorted) return std::nullopt;

  const Intrinsics k = intrinsics(camera);
  const Eigen::Vector2d focal(k.fx, k.fy);
  if (d_uv_d_p != nullptr) {
    Eigen::Matrix<double, 2, 3> d_xy_d_p;
    d_xy_d_p << Eigen::Matrix2d::Identity() / p_C.z(), -xy / p_C.z();
    *d_uv_d_p = focal.asDiagonal() * distorted->J * d_xy_d_p;
  }
  return focal.cwiseProduct(distorted->xy) + Eigen::Vector2d(k.cx, k.cy);
}

std::optional<Eigen::Vector3d> ray(const CameraModel& camera, const Eigen::Vector2d& uv_px,
                                   Eigen::Matrix2d* d_xy_d_uv) {
  if (!uv_px.allFinite()) return std::nullopt;
  const Intrinsics k = intrinsics(camera);
  const Eigen::Vector2d xy_d((uv_px.x() - k.cx) / k.fx, (uv_px.y() - k.cy) / k.fy);
  const auto ideal = camera.lens().undistort(xy_d);
  if (!ideal) return std::nullopt;
  if (d_xy_d_uv != nullptr)
    *d_xy_d_uv = ideal->J * Eigen::Vector2d(1.0 / k.fx, 1.0 / k.fy).asDiagonal();
  return Eigen::Vector3d(ideal->xy.x(), ideal->xy.y(), 1.0);
}

}  // namespace planar
