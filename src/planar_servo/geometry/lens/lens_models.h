#pragma once

#include <array>
#include <string>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/lens/camera_model.h"

namespace planar {

struct Pinhole {
  static constexpr const char* kName = "pinhole";

  Intrinsics k;

  static std::array<lens::Coefficient<Pinhole>, 0> coefficients() { return {}; }
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const { return lens::Mapped{xy}; }
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const {
    return lens::Mapped{xy};
  }
};

/// Is ViSP's perspective model [vpCameraParameters]: x_d = x (1 + kud r^2) one way and
/// x = x_d (1 + kdu r_d^2) the other. The fit finds both coefficients; neither follows from the
/// other.
struct VispModel {
  static constexpr const char* kName = "visp";

  Intrinsics k;
  double kud{0.0}, kdu{0.0};

  static std::array<lens::Coefficient<VispModel>, 2> coefficients() {
    return {{{&VispModel::kud}, {&VispModel::kdu}}};
  }
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
};

/// Is OpenCV's plumb-bob model [Brown 1966] with the radial coefficients k1, k2, k3 and the
/// decentring ones p1, p2.
struct PlumbBob {
  static constexpr const char* kName = "plumb_bob";

  Intrinsics k;
  double k1{0.0}, k2{0.0}, p1{0.0}, p2{0.0}, k3{0.0};

  static std::array<lens::Coefficient<PlumbBob>, 5> coefficients() {
    return {{{&PlumbBob::k1}, {&PlumbBob::k2}, {&PlumbBob::p1}, {&PlumbBob::p2}, {&PlumbBob::k3}}};
  }
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
};

/// Is OpenCV's rational model with the radial factor (1 + k1 r^2 + k2 r^4 + k3 r^6) /
/// (1 + k4 r^2 + k5 r^4 + k6 r^6) and decentring p1, p2.
struct Rational {
  static constexpr const char* kName = "rational_polynomial";

  Intrinsics k;
  double k1{0.0}, k2{0.0}, p1{0.0}, p2{0.0}, k3{0.0}, k4{0.0}, k5{0.0}, k6{0.0};

  static std::array<lens::Coefficient<Rational>, 8> coefficients() {
    using C = Rational;
    return {{{&C::k1}, {&C::k2}, {&C::p1}, {&C::p2}, {&C::k3}, {&C::k4}, {&C::k5}, {&C::k6}}};
  }
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
};

/// Is Kannala-Brandt's equidistant model as in OpenCV's fisheye [Kannala & Brandt 2006]:
/// theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
struct KannalaBrandt {
  static constexpr const char* kName = "equidistant";

  Intrinsics k;
  double k1{0.0}, k2{0.0}, k3{0.0}, k4{0.0};

  static std::array<lens::Coefficient<KannalaBrandt>, 4> coefficients() {
    using C = KannalaBrandt;
    return {{{&C::k1}, {&C::k2}, {&C::k3}, {&C::k4}}};
  }
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
};

/// Is OpenCV's model of 14 coefficients [Louhichi et al. 2007]. To the rational one it adds the
/// thin prism s1 r^2 + s2 r^4 along x and s3 r^2 + s4 r^4 along y, and it sees the result on a
/// sensor turned by tau_x about x and then by tau_y about y (radians, each within a right angle).
struct OpenCv14 : Rational {
  static constexpr const char* kName = "opencv_14";

  double s1{0.0}, s2{0.0}, s3{0.0}, s4{0.0}, tau_x{0.0}, tau_y{0.0};

  static std::array<lens::Coefficient<OpenCv14>, 14> coefficients() {
    using C = OpenCv14;
    constexpr double kRightAngle = kPi / 2.0;
    constexpr const char* kTilted = "a sensor tilted by a right angle or more";
    return {{{&C::k1},
             {&C::k2},
             {&C::p1},
             {&C::p2},
             {&C::k3},
             {&C::k4},
             {&C::k5},
             {&C::k6},
             {&C::s1},
             {&C::s2},
             {&C::s3},
             {&C::s4},
             {&C::tau_x, kRightAngle, kTilted},
             {&C::tau_y, kRightAngle, kTilted}}};
  }
  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const;
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const;
};

/// A way to calibrate a camera.
struct CalibrationModel {
  std::string name;    ///< as `--model` has it
  CameraModel sample;  ///< of its lens model, with distortion of the size that real lenses have
  std::size_t free_coefficients;  ///< how many of its first coefficients are estimated
  int auto_order{0};  ///< its place among those that `auto` tries, simplest first; 0 for others
};

/// Returns all of them. The lens models of files are those of the samples.
const std::vector<CalibrationModel>& calibration_models();

std::vector<CameraModel> sample_cameras();

/// Returns the camera with that lens model. Throws InputError for an unknown model; see
/// LensModel::with().
CameraModel make_camera_model(const std::string& lens_model, const Intrinsics& k,
                              const std::vector<double>& coefficients);

}  // namespace planar
