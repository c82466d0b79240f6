#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace planar {

/// Holds focal lengths and principal point in pixels: u = fx x + cx, v = fy y + cy.
struct Intrinsics {
  double fx{1.0}, fy{1.0}, cx{0.0}, cy{0.0};
};

namespace lens {

/// Holds a point of one normalised image plane and its Jacobian by the point of the other plane.
struct Mapped {
  Eigen::Vector2d xy{0.0, 0.0};
  Eigen::Matrix2d J = Eigen::Matrix2d::Identity();
};

/// One distortion coefficient of the lens model `Lens`.
template <typename Lens>
struct Coefficient {
  double Lens::*value;
  double limit{std::numeric_limits<double>::infinity()};  ///< its size is less than this
  const char* beyond{""};  ///< what a camera beyond the limit has, for the message
};

/// Throws InputError unless the focal lengths are positive, all numbers finite and the coefficients
/// no more than the lens model has.
void check_camera(const char* lens_model, const Intrinsics& k,
                  const std::vector<double>& coefficients, std::size_t most_coefficients);

[[noreturn]] void refuse_camera(const char* beyond);

}  // namespace lens

class CameraModel;

/// A camera with a lens of any kind, as all programs see it.
class LensModel {
 public:
  virtual ~LensModel() = default;
  virtual const char* name() const = 0;
  virtual const Intrinsics& k() const = 0;
  virtual std::vector<double> coefficients() const = 0;
  /// Returns a camera with the same lens model. Missing coefficients are zero. Throws InputError
  /// for too many coefficients, one beyond its limit, a number that is not finite or a focal length
  /// that is not positive.
  virtual CameraModel with(const Intrinsics& k, const std::vector<double>& values) const = 0;
  virtual std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const = 0;
  virtual std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const = 0;
};

/// Holds a camera with any lens. A lens model is a class like those in lens_models.h with
///   - kName: its name in files;
///   - k, the intrinsics, and the distortion coefficients by name, all zero unless set;
///   - coefficients(): an array of lens::Coefficient, in the order of OpenCV and ROS where they
///   have the model;
///   - distort(): from the ideal normalised image plane (x, y) = (X/Z, Y/Z) of points in the camera
///     frame C to the distorted one, with its Jacobian; empty where the mapping, followed outwards
///     from the axis, stops being one-to-one;
///   - undistort(): the way back, empty where no point of the one-to-one range maps to `xy`.
class CameraModel {
 public:
  /// Holds a pinhole camera with focal lengths of 1 px.
  CameraModel();

  template <typename Lens, typename = decltype(Lens::kName)>
  CameraModel(const Lens& lens) : lens_(std::make_shared<const LensOf<Lens>>(lens)) {}

  const LensModel& lens() const { return *lens_; }

  /// Returns the camera as one of that lens model; null when it is none.
  template <typename Lens>
  const Lens* as() const {
    const auto* of_model = dynamic_cast<const LensOf<Lens>*>(lens_.get());
    return of_model ? &of_model->held : nullptr;
  }

 private:
  template <typename Lens>
  struct LensOf;

  std::shared_ptr<const LensModel> lens_;
};

// These return what the functions k(), coefficients() and name() of the camera's LensModel do.
Intrinsics intrinsics(const CameraModel& camera);
std::vector<double> distortion_coefficients(const CameraModel& camera);
std::string lens_model_name(const CameraModel& camera);

/// Returns the camera whose fx, fy, cx, cy and first coefficients are changed by `step`. Throws
/// InputError as LensModel::with() does.
CameraModel moved_camera(const CameraModel& camera, const Eigen::VectorXd& step);

/// Returns the pixel of the point p_C (metres, camera frame). Empty when the point is not in front
/// of the camera, is not finite or lies where the lens model is not one-to-one. Sets the Jacobian
/// `d_uv_d_p` (px/m) unless it is null.
std::optional<Eigen::Vector2d> project(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                       Eigen::Matrix<double, 2, 3>* d_uv_d_p = nullptr);

/// Returns the ray (x, y, 1) of a pixel in the camera frame. Empty outside the model's range. Sets
/// the Jacobian `d_xy_d_uv` (1/px) unless it is null.
std::optional<Eigen::Vector3d> ray(const CameraModel& camera, const Eigen::Vector2d& uv_px,
                                   Eigen::Matrix2d* d_xy_d_uv = nullptr);

template <typename Lens>
struct CameraModel::LensOf : LensModel {
  explicit LensOf(const Lens& lens) : held(lens) {}

  const char* name() const override { return Lens::kName; }
  const Intrinsics& k() const override { return held.k; }

  std::vector<double> coefficients() const override {
    std::vector<double> values;
    for (const auto& coefficient : Lens::coefficients()) values.push_back(held.*coefficient.value);
    return values;
  }

  CameraModel with(const Intrinsics& k, const std::vector<double>& values) const override {
    const auto coefficients = Lens::coefficients();
    lens::check_camera(Lens::kName, k, values, coefficients.size());
    Lens made;
    made.k = k;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!(std::abs(values[i]) < coefficients[i].limit))
        lens::refuse_camera(coefficients[i].beyond);
      made.*coefficients[i].value = values[i];
    }
    return made;
  }

  std::optional<lens::Mapped> distort(const Eigen::Vector2d& xy) const override {
    return held.distort(xy);
  }
  std::optional<lens::Mapped> undistort(const Eigen::Vector2d& xy) const override {
    return held.undistort(xy);
  }

  Lens held;
};

}  // namespace planar
