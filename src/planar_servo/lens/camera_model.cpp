#include "planar_servo/lens/camera_model.h"

#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/lens/lens.h"

namespace planar {
namespace {

/// The lens models by name, in the order of CameraModel's alternatives.
struct LensModel {
  const char* name;
  std::size_t coefficients;
};
constexpr LensModel kLensModels[] = {{"pinhole", 0},     {"visp", 2},
                                     {"plumb_bob", 5},   {"rational_polynomial", 8},
                                     {"equidistant", 4}, {"opencv_14", 14}};

void require_sensor_in_sight(double tau_x, double tau_y) {
  if (std::abs(tau_x) < kPi / 2.0 && std::abs(tau_y) < kPi / 2.0) return;
  throw InputError("camera with a sensor tilted by " + std::to_string(tau_x) + " and " +
                   std::to_string(tau_y) + " rad; both must be less than a right angle");
}

Rational rational(const Intrinsics& k, const std::vector<double>& c) {
  return {k, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]};
}

CameraModel with_coefficients(std::size_t model, const Intrinsics& k,
                              const std::vector<double>& c) {
  switch (model) {
    case 0:
      return Pinhole{k};
    case 1:
      return VispModel{k, c[0], c[1]};
    case 2:
      return PlumbBob{k, c[0], c[1], c[2], c[3], c[4]};
    case 3:
      return rational(k, c);
    case 4:
      return KannalaBrandt{k, c[0], c[1], c[2], c[3]};
    default:
      require_sensor_in_sight(c[12], c[13]);
      return OpenCv14{rational(k, c), c[8], c[9], c[10], c[11], c[12], c[13]};
  }
}

std::vector<double> coefficients_of(const Pinhole&) {
  return {};
}
std::vector<double> coefficients_of(const VispModel& c) {
  return {c.kud, c.kdu};
}
std::vector<double> coefficients_of(const PlumbBob& c) {
  return {c.k1, c.k2, c.p1, c.p2, c.k3};
}
std::vector<double> coefficients_of(const Rational& c) {
  return {c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6};
}
std::vector<double> coefficients_of(const KannalaBrandt& c) {
  return {c.k1, c.k2, c.k3, c.k4};
}
std::vector<double> coefficients_of(const OpenCv14& c) {
  std::vector<double> result = coefficients_of(static_cast<const Rational&>(c));
  result.insert(result.end(), {c.s1, c.s2, c.s3, c.s4, c.tau_x, c.tau_y});
  return result;
}

bool all_finite(const std::vector<double>& values) {
  for (const double v : values) {
    if (!std::isfinite(v)) return false;
  }
  return true;
}

}  // namespace

std::optional<Eigen::Vector2d> project(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                       Eigen::Matrix<double, 2, 3>* d_uv_d_p) {
  if (!p_C.allFinite() || p_C.z() <= 0.0) return std::nullopt;
  const Eigen::Vector2d xy = p_C.head<2>() / p_C.z();
  if (!xy.allFinite()) return std::nullopt;
  const auto distorted = std::visit([&](const auto& c) { return lens::distort(c, xy); }, camera);
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
  const auto ideal = std::visit([&](const auto& c) { return lens::undistort(c, xy_d); }, camera);
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
  return std::visit([](const auto& c) { return coefficients_of(c); }, camera);
}

std::string lens_model_name(const CameraModel& camera) {
  return kLensModels[camera.index()].name;
}

CameraModel make_camera_model(const std::string& lens_model, const Intrinsics& k,
                              const std::vector<double>& coefficients) {
  std::string allowed;
  for (std::size_t model = 0; model < std::size(kLensModels); ++model) {
    const auto& [name, count] = kLensModels[model];
    allowed += (model == 0 ? "" : ", ") + std::string(name);
    if (lens_model != name) continue;
    if (coefficients.size() > count) {
      throw InputError("lens model " + lens_model + " has " + std::to_string(count) +
                       " coefficients, not " + std::to_string(coefficients.size()));
    }
    if (!all_finite(coefficients) || !all_finite({k.fx, k.fy, k.cx, k.cy}) || k.fx <= 0.0 ||
        k.fy <= 0.0) {
      throw InputError("camera with a focal length that is not positive or a number not finite");
    }
    std::vector<double> padded = coefficients;
    padded.resize(count, 0.0);
    return with_coefficients(model, k, padded);
  }
  throw InputError("unknown lens model '" + lens_model + "'; allowed are " + allowed);
}

}  // namespace planar
