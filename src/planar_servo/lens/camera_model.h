#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace planar {

/// Focal lengths and principal point in pixels: u = fx x + cx, v = fy y + cy.
struct Intrinsics {
  double fx{1.0}, fy{1.0}, cx{0.0}, cy{0.0};
};

// One struct per lens model. Each maps the ideal normalised image plane (x, y) = (X/Z, Y/Z) of
// points in the camera frame C to the distorted one, in the range about the axis in which the
// mapping is one-to-one.

/// No distortion.
struct Pinhole {
  Intrinsics k;
};

/// ViSP's perspective model [vpCameraParameters]: x_d = x (1 + kud r^2) one way and
/// x = x_d (1 + kdu r_d^2) the other, two coefficients that are fitted separately.
struct VispModel {
  Intrinsics k;
  double kud{0.0}, kdu{0.0};
};

/// OpenCV's plumb-bob model [Brown 1966]: radial k1, k2, k3 and decentring p1, p2.
struct PlumbBob {
  Intrinsics k;
  double k1{0.0}, k2{0.0}, p1{0.0}, p2{0.0}, k3{0.0};
};

/// OpenCV's rational model: radial (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
/// and decentring p1, p2.
struct Rational {
  Intrinsics k;
  double k1{0.0}, k2{0.0}, p1{0.0}, p2{0.0}, k3{0.0}, k4{0.0}, k5{0.0}, k6{0.0};
};

/// Kannala-Brandt's equidistant model as in OpenCV's fisheye [Kannala & Brandt 2006]:
/// theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
struct KannalaBrandt {
  Intrinsics k;
  double k1{0.0}, k2{0.0}, k3{0.0}, k4{0.0};
};

/// OpenCV's model of 14 coefficients: the rational one with the thin prism s1 r^2 + s2 r^4 added
/// along x and s3 r^2 + s4 r^4 along y, seen on a sensor turned by tau_x about x and then by tau_y
/// about y (radians, each within a right angle) [Louhichi et al. 2007].
struct OpenCv14 : Rational {
  double s1{0.0}, s2{0.0}, s3{0.0}, s4{0.0}, tau_x{0.0}, tau_y{0.0};
};

using CameraModel = std::variant<Pinhole, VispModel, PlumbBob, Rational, KannalaBrandt, OpenCv14>;

/// Pixel of the point p_C (metres, camera frame); empty when the point is not in front of the
/// camera, is not finite or lies where the lens model is not one-to-one. d_uv_d_p: 2 x 3, px/m.
std::optional<Eigen::Vector2d> project(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                       Eigen::Matrix<double, 2, 3>* d_uv_d_p = nullptr);

/// The ray (x, y, 1) of a pixel in the camera frame; empty outside the model's range.
/// d_xy_d_uv: 2 x 2, 1/px.
std::optional<Eigen::Vector3d> ray(const CameraModel& camera, const Eigen::Vector2d& uv_px,
                                   Eigen::Matrix2d* d_xy_d_uv = nullptr);

Intrinsics intrinsics(const CameraModel& camera);

/// Distortion coefficients in the model's own order (OpenCV's and ROS's for theirs): none; kud,
/// kdu; k1, k2, p1, p2, k3; the same and k4, k5, k6; k1 ... k4; those of the rational model and
/// s1, s2, s3, s4, tau_x, tau_y.
std::vector<double> distortion_coefficients(const CameraModel& camera);

/// "pinhole", "visp", "plumb_bob", "rational_polynomial", "equidistant" or "opencv_14".
std::string lens_model_name(const CameraModel& camera);

/// The camera with that lens model; missing coefficients are zero. Throws InputError for an unknown
/// model, too many coefficients, a number that is not finite, a focal length that is not positive
/// or a sensor tilted by a right angle or more.
CameraModel make_camera_model(const std::string& lens_model, const Intrinsics& k,
                              const std::vector<double>& coefficients);

}  // namespace planar
