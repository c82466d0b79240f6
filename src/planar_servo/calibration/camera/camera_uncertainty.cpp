#include "planar_servo/calibration/camera/camera_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/calibration/camera/lens_fit.h"

namespace planar {
namespace {

constexpr Eigen::Index kGrid = 41;
/// Of the focal lengths and the principal point, and of a coefficient.
constexpr double kStep_px = 1e-3, kStep = 1e-5;
/// The sum of squares rises by the variance along a step of one deviation, or about so; it may be
/// off so far, in variances, without changing a deviation by more than a fifth.
constexpr double kLeastRise = 0.7, kMostRise = 1.4;
/// Of a parameter's variance; if less does not hold, that changes its deviation by an eighth.
constexpr double kMostTraded = 0.25;

Eigen::Array4d four_of(const CameraModel& camera) {
  const Intrinsics k = intrinsics(camera);
  return {k.fx, k.fy, k.cx, k.cy};
}

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Returns the sum of squares that a camera leaves when its parameters are moved by a step and the
/// boards' poses follow; NaN where a board cannot be seen so, or no camera is so.
double squares_left(const CameraModel& camera, const Eigen::VectorXd& step,
                    const std::vector<CalibrationView>& views) try {
  const CameraModel moved = moved_camera(camera, step);
  double squares = 0.0;
  for (const CalibrationView& view : views) {
    const auto pose = estimate_board_pose(moved, view.points_G, view.pixels);
    if (!pose) return kUnknown;
    squares += pose->rms_px * pose->rms_px * static_cast<double>(view.pixels.size());
  }
  return squares;
} catch (const InputError&) {
  return kUnknown;
}

cv::Point2f float_point(const Eigen::Vector2d& uv) {
  return {static_cast<float>(uv.x()), static_cast<float>(uv.y())};
}

std::vector<cv::Point2f> hull_of(const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<cv::Point2f> points, corners;
  points.reserve(pixels.size());
  for (const Eigen::Vector2d& uv : pixels) points.push_back(float_point(uv));
  cv::convexHull(points, corners);
  return corners;
}

/// The pixels of a grid that lie in the hull and have rays, and how their points in the plane move.
class PlaneField {
 public:
  PlaneField(const CameraModel& camera, const PlaneError& error,
             const std::vector<cv::Point2f>& hull)
      : camera_(camera), distance_(error.distance) {
    for (Eigen::Index row = 0; row < kGrid; ++row)
      for (Eigen::Index column = 0; column < kGrid; ++column) {
        const Eigen::Vector2d share(static_cast<double>(column) / (kGrid - 1),
                                    static_cast<double>(row) / (kGrid - 1));
        const Eigen::Vector2d uv = error.from_px + share.cwiseProduct(error.to_px - error.from_px);
        const auto seen = ray(camera, uv);
        if (!seen || cv::pointPolygonTest(hull, float_point(uv), false) < 0.0) continue;
        pixels_.push_back(uv);
        cells_.emplace_back(row, column);
        points_.emplace_back(distance_ * seen->head<2>());
      }
    pose_ = pose_moves();
  }

  Eigen::Index rows() const { return 2 * static_cast<Eigen::Index>(points_.size()); }
  const std::vector<std::pair<Eigen::Index, Eigen::Index>>& cells() const { return cells_; }

  /// Returns how the points move with each of the first parameters, the plane's pose fitted: a
  /// pixel stays, and its ray makes up for what the parameter does to the projection.
  Eigen::MatrixXd by_parameters(Eigen::Index parameters) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows(), parameters);
    for (Eigen::Index c = 0; c < parameters; ++c) {
      const double size = c < 4 ? kStep_px : kStep;
      const Eigen::VectorXd step = size * Eigen::VectorXd::Unit(parameters, c);
      const CameraModel more = moved_camera(camera_, step), less = moved_camera(camera_, -step);
      for (std::size_t i = 0; i < pixels_.size(); ++i) {
        Eigen::Matrix2d xy_by_uv;
        const auto seen = ray(camera_, pixels_[i], &xy_by_uv);
        const auto a = project(more, *seen), b = project(less, *seen);
        if (a && b)
          J.block<2, 1>(2 * static_cast<Eigen::Index>(i), c) =
              -distance_ / (2.0 * size) * xy_by_uv * (*a - *b);
      }
    }
    return without_pose(J);
  }

  /// Returns how far another camera's points lie from these, the plane's pose fitted; zero where it
  /// has no ray.
  Eigen::VectorXd by_camera(const CameraModel& other) const {
    Eigen::VectorXd off = Eigen::VectorXd::Zero(rows());
    for (std::size_t i = 0; i < pixels_.size(); ++i)
      if (const auto seen = ray(other, pixels_[i]))
        off.segment<2>(2 * static_cast<Eigen::Index>(i)) = distance_ * seen->head<2>() - points_[i];
    return without_pose(off);
  }

 private:
  /// Returns how the points move with shift, turn, height and two tilts of the plane.
  Eigen::MatrixXd pose_moves() const {
    Eigen::MatrixXd moves(rows(), 6);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double x = points_[i].x() / distance_, y = points_[i].y() / distance_;
      moves.middleRows<2>(2 * static_cast<Eigen::Index>(i)) << 1.0, 0.0, -y, x, x * x, x * y,  //
          0.0, 1.0, x, y, x * y, y * y;
    }
    return moves;
  }

  Eigen::MatrixXd without_pose(const Eigen::MatrixXd& moves) const {
    return moves - pose_ * solve_symmetric(pose_.transpose() * pose_, pose_.transpose() * moves);
  }

  const CameraModel& camera_;
  double distance_;
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> cells_;
  std::vector<Eigen::Vector2d> points_;
  Eigen::MatrixXd pose_;
};

/// Returns the variance of each point, both axes together.
Eigen::ArrayXd variances(const Eigen::MatrixXd& J, const Eigen::MatrixXd& covariance) {
  const auto used = J.leftCols(covariance.rows());
  const Eigen::ArrayXd by_axis = (used * covariance).cwiseProduct(used).rowwise().sum();
  return by_axis.reshaped(2, by_axis.size() / 2).colwise().sum().transpose();
}

constexpr double kNoises = 3.0;
/// A motion is small below this share of the board's size in the image.
constexpr double kSmallMotion = 0.05;
constexpr Eigen::Index kParameters = 8;

/// Returns how the image of a plane moves at a point when the plane moves a little: the derivative
/// of a homography at the identity by its eight parameters.
Eigen::Matrix<double, 2, kParameters> small_motion(const Eigen::Vector2d& at) {
  const double x = at.x(), y = at.y();
  Eigen::Matrix<double, 2, kParameters> J;
  J << 1.0, x, y, 0.0, 0.0, 0.0, x * x, x * y,  //
      0.0, 0.0, 0.0, 1.0, x, y, x * y, y * y;
  return J;
}

bool repeats(const CalibrationView& view, const CalibrationView& earlier) {
  if (view.points_G != earlier.points_G) return false;
  const std::vector<Eigen::Vector2d> about_centre = about_centroid(earlier.pixels);
  const double size_px = rms_length(about_centre);
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(view.pixels.size());
  Eigen::MatrixXd J(rows, kParameters);
  Eigen::VectorXd distances_px(rows);
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    J.middleRows<2>(row) = small_motion(about_centre[i] / size_px);
    distances_px.segment<2>(row) = view.pixels[i] - earlier.pixels[i];
  }
  const double mean_square = distances_px.squaredNorm() / static_cast<double>(rows);
  if (mean_square > std::pow(kSmallMotion * size_px, 2)) return false;
  const Eigen::VectorXd noise = distances_px - J * solve_least_squares(J, distances_px);
  const double variance = noise.squaredNorm() / static_cast<double>(rows - kParameters);
  return mean_square <= kNoises * kNoises * variance;
}

}  // namespace

Eigen::VectorXd deviations(const CameraUncertainty& uncertainty, const CameraModel& camera) {
  Eigen::VectorXd variances = uncertainty.by_residuals.diagonal();
  if (const auto& by_views = uncertainty.by_views) {
    auto known = variances.head(by_views->rows());
    known = known.cwiseMax(by_views->diagonal());
  }
  Eigen::Array4d differences = Eigen::Array4d::Zero();
  for (const CameraModel& other : uncertainty.as_good)
    differences = differences.max((four_of(other) - four_of(camera)).abs());
  variances.head<4>().array() += differences.square();
  variances(uncertainty.traded_off).setConstant(kUnknown);
  return variances.cwiseSqrt();
}

double PlaneError::mean() const {
  const auto known = sigma.array().isFinite();
  return known.select(sigma.array(), 0.0).sum() / static_cast<double>(known.count());
}

double PlaneError::largest() const {
  return sigma.array().isFinite().select(sigma.array(), 0.0).maxCoeff();
}

double PlaneError::at(const Eigen::Vector2d& uv_px) const {
  const Eigen::Array2d share = (uv_px - from_px).array() / (to_px - from_px).array();
  if (!((share >= 0.0).all() && (share <= 1.0).all())) return kUnknown;
  return sigma(std::lround(share.y() * static_cast<double>(sigma.rows() - 1)),
               std::lround(share.x() * static_cast<double>(sigma.cols() - 1)));
}

PlaneError plane_error(const CameraModel& camera, const CameraUncertainty& uncertainty,
                       const std::vector<Eigen::Vector2d>& seen, double distance) {
  PlaneError error;
  error.distance = distance;
  error.from_px = error.to_px = seen.at(0);
  for (const Eigen::Vector2d& uv : seen) {
    error.from_px = error.from_px.cwiseMin(uv);
    error.to_px = error.to_px.cwiseMax(uv);
  }
  error.sigma.setConstant(kGrid, kGrid, kUnknown);
  const PlaneField field(camera, error, hull_of(seen));
  const Eigen::MatrixXd J = field.by_parameters(uncertainty.by_residuals.rows());
  Eigen::ArrayXd squares = variances(J, uncertainty.by_residuals);
  if (uncertainty.by_views) squares = squares.max(variances(J, *uncertainty.by_views));
  Eigen::ArrayXd differences = Eigen::ArrayXd::Zero(squares.size());
  for (const CameraModel& other : uncertainty.as_good) {
    const Eigen::ArrayXd off = field.by_camera(other).array().square();
    differences = differences.max(off.reshaped(2, off.size() / 2).colwise().sum().transpose());
  }
  const Eigen::ArrayXd sigma = (squares + differences).sqrt();
  for (std::size_t i = 0; i < field.cells().size(); ++i)
    error.sigma(field.cells()[i].first, field.cells()[i].second) =
        sigma[static_cast<Eigen::Index>(i)];
  return error;
}

std::vector<Eigen::Index> traded_off(const LensFit& fit, const std::vector<CalibrationView>& views,
                                     std::size_t free_coefficients) {
  const auto information = fit_information(fit, views, free_coefficients);
  const auto steps = information ? independent_steps(information->jacobians) : std::nullopt;
  if (!steps) return {};
  const double variance = information->squares / information->freedom;
  const auto left = [&](const Eigen::VectorXd& step) {
    return squares_left(fit.camera, std::sqrt(variance) * step, views) / variance;
  };
  const double least = left(Eigen::VectorXd::Zero(steps->rows()));
  const auto raises = [&](const Eigen::VectorXd& step) {
    const double rise = left(step) - least;
    return rise > kLeastRise && rise < kMostRise;
  };
  Eigen::VectorXd all = Eigen::VectorXd::Zero(steps->rows()), traded = all;
  for (const Eigen::VectorXd step : steps->colwise()) {
    all += step.cwiseAbs2();
    if (!raises(step) || !raises(-step)) traded += step.cwiseAbs2();
  }
  std::vector<Eigen::Index> parameters;
  for (Eigen::Index i = 0; i < all.size(); ++i)
    if (traded[i] > kMostTraded * all[i]) parameters.push_back(i);
  return parameters;
}

void drop_repeated_views(std::vector<CalibrationView>& views, std::vector<Rejection>& rejected) {
  std::vector<CalibrationView> distinct;
  for (CalibrationView& view : views) {
    const auto other =
        std::find_if(distinct.begin(), distinct.end(),
                     [&](const CalibrationView& earlier) { return repeats(view, earlier); });
    if (other == distinct.end()) {
      distinct.push_back(std::move(view));
    } else {
      rejected.push_back({view.name, "it shows the board as " + other->name +
                                         " does, within the noise, and adds nothing"});
    }
  }
  views = std::move(distinct);
}

}  // namespace planar
