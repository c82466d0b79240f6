#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "planar_servo/lens/models/kannala_brandt.h"
#include "planar_servo/lens/models/open_cv_14.h"
#include "planar_servo/lens/models/pinhole.h"
#include "planar_servo/lens/models/plumb_bob.h"
#include "planar_servo/lens/models/rational.h"
#include "planar_servo/lens/models/visp_model.h"

namespace planar {

/// Holds a camera by its lens model, which is one of a closed set. To add a lens, write one class
/// like those in lens/models and name it here. Such a class has
///   - kName: its name in programs and files;
///   - Coefficients: an array of its distortion coefficients, in the order of OpenCV and ROS where
///   they have the model;
///   - k, the intrinsics, and the coefficients by name;
///   - with(k, coefficients) and coefficients(), which are each other's inverse;
///   - distort(): from the ideal normalised image plane (x, y) = (X/Z, Y/Z) of points in the camera
///     frame C to the distorted one, with its Jacobian; empty where the mapping, followed outwards
///     from the axis, stops being one-to-one;
///   - undistort(): the way back, empty where no point of the one-to-one range maps to `xy`;
///     kUndistortsExactly says whether it is the inverse of distort() or a separate fit;
///   - sample(): a camera with distortion of the size that real lenses have, on which the tests of
///     all models run.
using CameraModel = std::variant<Pinhole, VispModel, PlumbBob, Rational, KannalaBrandt, OpenCv14>;

/// Returns the pixel of the point p_C (metres, camera frame). Empty when the point is not in front
/// of the camera, is not finite or lies where the lens model is not one-to-one. Sets the Jacobian
/// `d_uv_d_p` (px/m) unless it is null.
std::optional<Eigen::Vector2d> project(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                       Eigen::Matrix<double, 2, 3>* d_uv_d_p = nullptr);

/// Returns the ray (x, y, 1) of a pixel in the camera frame. Empty outside the model's range. Sets
/// the Jacobian `d_xy_d_uv` (1/px) unless it is null.
std::optional<Eigen::Vector3d> ray(const CameraModel& camera, const Eigen::Vector2d& uv_px,
                                   Eigen::Matrix2d* d_xy_d_uv = nullptr);

Intrinsics intrinsics(const CameraModel& camera);

/// Returns the model's Coefficients.
std::vector<double> distortion_coefficients(const CameraModel& camera);

/// Returns the model's kName.
std::string lens_model_name(const CameraModel& camera);

/// Returns the sample camera of every lens model, in the order of CameraModel's alternatives.
std::vector<CameraModel> sample_cameras();

/// Returns the camera with that lens model. Missing coefficients are zero. Throws InputError for an
/// unknown model, too many coefficients, a number that is not finite, a focal length that is not
/// positive or a sensor tilted by a right angle or more.
CameraModel make_camera_model(const std::string& lens_model, const Intrinsics& k,
                              const std::vector<double>& coefficients);

}  // namespace planar
