#include "planar_servo/lens/camera_model.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

template <std::size_t... kModels>
std::vector<CameraModel> samples_of(std::index_sequence<kModels...>) {
  return {std::variant_alternative_t<kModels, CameraModel>::sample()...};
}

bool is_usable(const Intrinsics& k, const std::vector<double>& coefficients) {
  const auto is_finite = [](double v) { return std::isfinite(v); };
  return std::all_of(coefficients.begin(), coefficients.end(), is_finite) && is_finite(k.fx) &&
         is_finite(k.fy) && is_finite(k.cx) && is_finite(k.cy) && k.fx > 0.0 && k.fy > 0.0;
}

template <typename Model>
CameraModel make(const Intrinsics& k, const std::vector<double>& coefficients) {
  typename Model::Coefficients padded{};
  if (coefficients.size() > padded.size()) {
    throw InputError(std::string("lens model ") + Model::kName + " has " +
                     std::to_string(padded.size()) + " coefficients, not " +
                     std::to_string(coefficients.size()));
  }
  if (!is_usable(k, coefficients))
    throw InputError("a focal length is not positive or a number of the camera is not finite");
  std::copy(coefficients.begin(), coefficients.end(), padded.begin());
  return Model::with(k, padded);
}

}  // namespace

std::optional<Eigen::Vector2d> project(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                       Eigen::Matrix<double, 2, 3>* d_uv_d_p) {
  if (!p_C.allFinite() || p_C.z() <= 0.0) return std::nullopt;
  const Eigen::Vector2d xy = p_C.head<2>() / p_C.z();
  if (!xy.allFinite()) return std::nullopt;
  const auto distorted = std::visit([&](const auto& c) { return c.distort(xy); }, camera);
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
  const auto ideal = std::visit([&](const auto& c) { return c.undistort(xy_d); }, camera);
  if (!ideal) return std::nullopt;
  if (d_xy_d_uv != nullptr) {
    *d_xy_d_uv = ideal->J * Eigen::Vector2d(1.0 / k.fx, 1.0 / k.fy).asDiagonal();
  }
  return Eigen::Vector3d(ideal->xy.x(), ideal->xy.y(), 1.0);
}

Intrinsics intrinsics(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.k; }, camera);
}

std::vector<double> distortion_coefficients(const CameraModel& camera) {
  return std::visit(
      [](const auto& c) {
        const auto coefficients = c.coefficients();
        return std::vector<double>(coefficients.begin(), coefficients.end());
      },
      camera);
}

std::string lens_model_name(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.kName; }, camera);
}

std::vector<CameraModel> sample_cameras() {
  return samples_of(std::make_index_sequence<std::variant_size_v<CameraModel>>());
}

CameraModel make_camera_model(const std::string& lens_model, const Intrinsics& k,
                              const std::vector<double>& coefficients) {
  std::string allowed;
  for (const CameraModel& sample : sample_cameras()) {
    const std::string name = lens_model_name(sample);
    allowed += (allowed.empty() ? "" : ", ") + name;
    if (lens_model != name) continue;
    return std::visit(
        [&](const auto& model) { return make<std::decay_t<decltype(model)>>(k, coefficients); },
        sample);
  }
  throw InputError("unknown lens model '" + lens_model + "'; allowed are " + allowed);
}

}  // namespace planar
