#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/calibration/camera/lens_fit.h"

namespace planar {
namespace {

constexpr double kNoises = 3.0;
/// A motion is small below this share of the board's size in the image.
constexpr double kSmallMotion = 0.05;
constexpr Eigen::Index kParameters = 8;

/// Holds points about their centre, scaled to a root mean square distance of 1 from it.
struct UnitPoints {
  std::vector<Eigen::Vector2d> points;
  double size_px{0.0};
};

UnitPoints unit_points(const std::vector<Eigen::Vector2d>& pixels) {
  const double n = static_cast<double>(pixels.size());
  Eigen::Vector2d centre(0.0, 0.0);
  for (const Eigen::Vector2d& uv : pixels) centre += uv / n;
  double squares = 0.0;
  for (const Eigen::Vector2d& uv : pixels) squares += (uv - centre).squaredNorm();
  UnitPoints result;
  result.size_px = std::sqrt(squares / n);
  for (const Eigen::Vector2d& uv : pixels)
    result.points.emplace_back((uv - centre) / result.size_px);
  return result;
}

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
  const UnitPoints unit = unit_points(earlier.pixels);
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(view.pixels.size());
  Eigen::MatrixXd J(rows, kParameters);
  Eigen::VectorXd distances_px(rows);
  for (std::size_t i = 0; i < view.pixels.size(); ++i) {
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    J.middleRows<2>(row) = small_motion(unit.points[i]);
    distances_px.segment<2>(row) = view.pixels[i] - earlier.pixels[i];
  }
  const double mean_square = distances_px.squaredNorm() / static_cast<double>(rows);
  if (mean_square > std::pow(kSmallMotion * unit.size_px, 2)) return false;
  const Eigen::VectorXd noise = distances_px - J * solve_least_squares(J, distances_px);
  const double variance = noise.squaredNorm() / static_cast<double>(rows - kParameters);
  return mean_square <= kNoises * kNoises * variance;
}

}  // namespace

void drop_repeated_views(std::vector<CalibrationView>& views, std::vector<RejectedView>& rejected) {
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
