#include "planar_servo/offline/camera/image_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar {
namespace {

constexpr int kCellsAlongLongerSide = 20;
constexpr double kCorner = 0.2;

/// Sums of the residuals in each cell.
struct CellSums {
  Eigen::MatrixXd u, v, squares;
};

/// Returns the mean square, over the points, of what the residuals of a cell have in common. Of the
/// square of a mean of n, the n-th part of the variance is chance.
double common_square(const ImageCoverage& coverage, const CellSums& sums) {
  double common = 0.0, points = 0.0;
  for (Eigen::Index i = 0; i < coverage.points.size(); ++i) {
    const double n = coverage.points(i);
    if (n < 2.0) continue;
    const double of_mean = (sums.u(i) * sums.u(i) + sums.v(i) * sums.v(i)) / (n * n);
    const double variance = (sums.squares(i) - n * of_mean) / (n - 1.0);
    common += n * (of_mean - variance / n);
    points += n;
  }
  return points > 0.0 ? std::max(0.0, common / points) : 0.0;
}

}  // namespace

ImageCoverage coverage_of(const CameraCalibration& found) {
  ImageCoverage coverage;
  coverage.cell_px =
      static_cast<double>(std::max(found.width_px, found.height_px)) / kCellsAlongLongerSide;
  const auto cells = [&](int pixels) {
    return static_cast<Eigen::Index>(std::ceil(pixels / coverage.cell_px - 1e-9));
  };
  const Eigen::Index rows = cells(found.height_px), columns = cells(found.width_px);
  coverage.points = Eigen::MatrixXi::Zero(rows, columns);
  CellSums sums;
  sums.u = sums.v = sums.squares = Eigen::MatrixXd::Zero(rows, columns);
  for (const CalibratedView& view : found.views)
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      const Eigen::Vector2d at = (view.pixels[i].array() + 0.5).matrix() / coverage.cell_px;
      const auto row = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(at.y()), 0, rows - 1);
      const auto column =
          std::clamp<Eigen::Index>(static_cast<Eigen::Index>(at.x()), 0, columns - 1);
      const Eigen::Vector2d& residual = view.residuals_px[i];
      ++coverage.points(row, column);
      sums.u(row, column) += residual.x();
      sums.v(row, column) += residual.y();
      sums.squares(row, column) += residual.squaredNorm();
    }
  coverage.common_px = std::sqrt(common_square(coverage, sums));
  return coverage;
}

double ImageCoverage::points_at(const Eigen::Vector2d& uv_px) const {
  const Eigen::Vector2d at = (uv_px.array() + 0.5).matrix() / cell_px;
  const auto row = static_cast<Eigen::Index>(at.y()), column = static_cast<Eigen::Index>(at.x());
  const bool seen = at.minCoeff() >= 0.0 && row < points.rows() && column < points.cols() &&
                    points(row, column) > 0;
  return seen ? points(row, column) : std::numeric_limits<double>::quiet_NaN();
}

double ImageCoverage::share() const {
  return static_cast<double>((points.array() > 0).count()) / static_cast<double>(points.size());
}

std::vector<std::string> ImageCoverage::empty_corners() const {
  const auto fifth = [](Eigen::Index cells) {
    return static_cast<Eigen::Index>(std::ceil(kCorner * static_cast<double>(cells)));
  };
  const Eigen::Index high = fifth(points.rows()), wide = fifth(points.cols());
  std::vector<std::string> empty;
  if (points.topLeftCorner(high, wide).sum() == 0) empty.emplace_back("upper left");
  if (points.topRightCorner(high, wide).sum() == 0) empty.emplace_back("upper right");
  if (points.bottomLeftCorner(high, wide).sum() == 0) empty.emplace_back("lower left");
  if (points.bottomRightCorner(high, wide).sum() == 0) empty.emplace_back("lower right");
  return empty;
}

}  // namespace planar
