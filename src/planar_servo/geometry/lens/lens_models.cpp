#include "planar_servo/geometry/lens/lens_models.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/lens/radial_map.h"

namespace planar {
namespace {

using lens::Mapped;
using lens::polynomial;
using lens::RadialMap;

RadialMap one_coefficient(double coefficient) {
  return RadialMap(polynomial({1.0, coefficient}));
}

RadialMap map_of(const PlumbBob& c) {
  return RadialMap(polynomial({1.0, c.k1, c.k2, c.k3}), polynomial({1.0}), {c.p1, c.p2});
}

RadialMap map_of(const Rational& c, const lens::LateralTerms& lateral) {
  return RadialMap(polynomial({1.0, c.k1, c.k2, c.k3}), polynomial({1.0, c.k4, c.k5, c.k6}),
                   lateral);
}

/// Returns the mapping of the plane of ray angles (theta cos phi, theta sin phi).
RadialMap angle_map(const KannalaBrandt& c) {
  return RadialMap(polynomial({1.0, c.k1, c.k2, c.k3, c.k4}));
}

/// Scales `from` to the length `to_length`, whose derivative by |from| is `slope`.
Mapped rescaled(const Eigen::Vector2d& from, double to_length, double slope) {
  const double length = from.norm();
  if (length < 1e-8) return {from, Eigen::Matrix2d::Identity()};
  const double scale = to_length / length;
  const Eigen::Vector2d along = from / length;
  return {scale * from,
          scale * Eigen::Matrix2d::Identity() + (slope - scale) * along * along.transpose()};
}

Mapped angle_from_tangent(const Eigen::Vector2d& xy) {
  return rescaled(xy, std::atan(xy.norm()), 1.0 / (1.0 + xy.squaredNorm()));
}

std::optional<Mapped> tangent_from_angle(const Eigen::Vector2d& angle) {
  if (!(angle.norm() < kPi / 2.0)) return std::nullopt;
  const double tangent = std::tan(angle.norm());
  return rescaled(angle, tangent, 1.0 + tangent * tangent);
}

/// Returns the mapping onto an image plane that is not tilted.
RadialMap upright_map(const OpenCv14& c) {
  return map_of(c, {c.p1, c.p2, c.s1, c.s2, c.s3, c.s4});
}

/// Returns the homography from the upright image plane to the tilted one, through the centre of
/// projection. The axis stays where it is [OpenCV, module calib3d].
Eigen::Matrix3d tilt_homography(const OpenCv14& c) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(-c.tau_y, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(-c.tau_x, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  Eigen::Matrix3d onto_plane;
  onto_plane << R(2, 2), 0.0, -R(0, 2), 0.0, R(2, 2), -R(1, 2), 0.0, 0.0, 1.0;
  return onto_plane * R;
}

/// Maps a point by the homography H. Empty on and beyond the line that H sends to infinity.
std::optional<Mapped> mapped_by(const Eigen::Matrix3d& H, const Eigen::Vector2d& xy) {
  const Eigen::Vector3d image = H * xy.homogeneous();
  if (!(image.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d at = image.hnormalized();
  if (!at.allFinite()) return std::nullopt;
  return Mapped{at, (H.topLeftCorner<2, 2>() - at * H.row(2).head<2>()) / image.z()};
}

}  // namespace

std::optional<Mapped> VispModel::distort(const Eigen::Vector2d& xy) const {
  return one_coefficient(kud).distort(xy);
}

std::optional<Mapped> VispModel::undistort(const Eigen::Vector2d& xy) const {
  return one_coefficient(kdu).distort(xy);
}

std::optional<Mapped> PlumbBob::distort(const Eigen::Vector2d& xy) const {
  return map_of(*this).distort(xy);
}

std::optional<Mapped> PlumbBob::undistort(const Eigen::Vector2d& xy) const {
  return map_of(*this).undistort(xy);
}

std::optional<Mapped> Rational::distort(const Eigen::Vector2d& xy) const {
  return map_of(*this, {p1, p2}).distort(xy);
}

std::optional<Mapped> Rational::undistort(const Eigen::Vector2d& xy) const {
  return map_of(*this, {p1, p2}).undistort(xy);
}

std::optional<Mapped> KannalaBrandt::distort(const Eigen::Vector2d& xy) const {
  const Mapped angle = angle_from_tangent(xy);
  auto distorted = angle_map(*this).distort(angle.xy);
  if (distorted) distorted->J *= angle.J;
  return distorted;
}

std::optional<Mapped> KannalaBrandt::undistort(const Eigen::Vector2d& xy) const {
  const auto angle = angle_map(*this).undistort(xy);
  if (!angle) return std::nullopt;
  auto tangent = tangent_from_angle(angle->xy);
  if (tangent) tangent->J *= angle->J;
  return tangent;
}

std::optional<Mapped> OpenCv14::distort(const Eigen::Vector2d& xy) const {
  const auto upright = upright_map(*this).distort(xy);
  if (!upright) return std::nullopt;
  auto tilted = mapped_by(tilt_homography(*this), upright->xy);
  if (tilted) tilted->J *= upright->J;
  return tilted;
}

std::optional<Mapped> OpenCv14::undistort(const Eigen::Vector2d& xy) const {
  const auto upright = mapped_by(tilt_homography(*this).inverse(), xy);
  if (!upright) return std::nullopt;
  auto ideal = upright_map(*this).undistort(upright->xy);
  if (ideal) ideal->J *= upright->J;
  return ideal;
}

const std::vector<CalibrationModel>& calibration_models() {
  static constexpr Intrinsics k{5200.0, 5190.0, 2570.0, 2540.0};
  static const Rational rational{k, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002};
  static const std::vector<CalibrationModel> models{
      {"pinhole", Pinhole{k}, 0, 1},
      {"plumb_bob_k1", PlumbBob{k, -0.12, 0.05, 4e-4, -3e-4, -0.01}, 1, 2},
      {"plumb_bob", PlumbBob{k, -0.12, 0.05, 4e-4, -3e-4, -0.01}, 5, 3},
      {"rational_polynomial", rational, 8, 5},
      {"opencv_14", OpenCv14{rational, 4e-4, -2e-4, -3e-4, 1e-4, 0.03, -0.02}, 14},
      {"equidistant", KannalaBrandt{k, -0.03, 0.006, -0.002, 3e-4}, 4, 4},
      {"visp", VispModel{k, 0.05, -0.047}, 2}};
  return models;
}

std::vector<CameraModel> sample_cameras() {
  std::vector<CameraModel> samples;
  for (const CalibrationModel& model : calibration_models()) {
    if (samples.empty() || lens_model_name(samples.back()) != lens_model_name(model.sample))
      samples.push_back(model.sample);
  }
  return samples;
}

CameraModel make_camera_model(const std::string& lens_model, const Intrinsics& k,
                              const std::vector<double>& coefficients) {
  std::string allowed;
  for (const CameraModel& sample : sample_cameras()) {
    const std::string name = lens_model_name(sample);
    if (lens_model == name) return sample.lens().with(k, coefficients);
    allowed += (allowed.empty() ? "" : ", ") + name;
  }
  throw InputError({"unknown lens model '" + lens_model + "'", "allowed are " + allowed});
}

}  // namespace planar
