#include "planar_servo/learn/field/field_basis.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

// A Gaussian process is all but reproduced by Gaussians three quarters of their width apart.
constexpr double kSpacingOverWidth = 0.75;
constexpr int kMostCenters = 200, kMostInSpan = 100;
/// Beyond the last places the centres continue a little, or the field would bend there.
constexpr double kBeyond = 1.05;
/// Keeps the kernel's matrix positive definite in double precision.
constexpr double kJitter = 1e-8;

}  // namespace

Eigen::RowVectorXd FieldBasis::at(const Eigen::Vector2d& p) const {
  Eigen::RowVectorXd row(terms());
  row.head(centers.cols()) = gaussians(p);
  const double x = p.x() / radius, y = p.y() / radius;
  row.tail<kQuadratic>() << 1.0, x, y, x * x, x * y, y * y;
  return row;
}

Eigen::RowVectorXd FieldBasis::gaussians(const Eigen::Vector2d& p) const {
  return ((centers.colwise() - p).colwise().squaredNorm() / (-2.0 * width * width)).array().exp();
}

Eigen::MatrixXd FieldBasis::kernel_matrix() const {
  Eigen::MatrixXd K(centers.cols(), centers.cols());
  for (Eigen::Index j = 0; j < centers.cols(); ++j) K.row(j) = gaussians(centers.col(j));
  K.diagonal().array() += kJitter;
  return K;
}

FieldBasis basis_over_disc(double radius, double width) {
  const double outer = kBeyond * radius, spacing = kSpacingOverWidth * width;
  const int count =
      std::clamp(static_cast<int>(kPi * outer * outer / (spacing * spacing)), 1, kMostCenters);
  return {spiral_over_disc(outer, count), width, radius};
}

FieldBasis basis_over_span(double first, double last, double width) {
  width = std::max(width, (last - first) / (kSpacingOverWidth * kMostInSpan));
  const auto steps =
      static_cast<Eigen::Index>(std::ceil((last - first) / (kSpacingOverWidth * width)));
  Eigen::Matrix2Xd centers = Eigen::Matrix2Xd::Zero(2, steps + 1);
  centers.row(0) = Eigen::RowVectorXd::LinSpaced(steps + 1, first, last);
  return {centers, width};
}

}  // namespace planar
