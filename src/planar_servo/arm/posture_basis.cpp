#include "planar_servo/arm/posture_basis.h"

#include <cmath>

namespace planar {
namespace {

// A Gaussian process is all but reproduced by Gaussians three quarters of their width apart.
constexpr double kSpacingOverWidth = 0.75;
constexpr std::size_t kMostCenters = 80;
/// Keeps the kernel's matrix positive definite in double precision.
constexpr double kJitter = 1e-8;

Eigen::Vector3d coordinates(const Joints& theta) {
  return {std::cos(theta[0]), std::sin(theta[0]), theta[1] - theta[0]};
}

Eigen::RowVectorXd gaussians(const PostureBasis& basis, const Eigen::Vector3d& u) {
  const double scale = -0.5 / (basis.width * basis.width);
  return ((basis.centers.colwise() - u).colwise().squaredNorm() * scale).array().exp();
}

}  // namespace

Eigen::RowVectorXd PostureBasis::at(const Joints& theta) const {
  return gaussians(*this, coordinates(theta));
}

Eigen::MatrixXd PostureBasis::kernel_matrix() const {
  Eigen::MatrixXd K(terms(), terms());
  for (Eigen::Index j = 0; j < terms(); ++j) K.row(j) = gaussians(*this, centers.col(j));
  K.diagonal().array() += kJitter;
  return K;
}

PostureBasis basis_over_postures(const std::vector<Joints>& postures, double width) {
  PostureBasis basis{{}, width};
  if (postures.empty()) return basis;
  const auto n = static_cast<Eigen::Index>(postures.size());
  Eigen::Matrix3Xd places(3, n);
  for (Eigen::Index i = 0; i < n; ++i)
    places.col(i) = coordinates(postures[static_cast<std::size_t>(i)]);
  // Each further centre is the posture that lies farthest from those before.
  const double spacing = kSpacingOverWidth * width;
  std::vector<Eigen::Index> chosen{0};
  Eigen::VectorXd nearest = (places.colwise() - places.col(0)).colwise().norm();
  for (Eigen::Index farthest = 0;
       chosen.size() < kMostCenters && nearest.maxCoeff(&farthest) > spacing;) {
    chosen.push_back(farthest);
    nearest =
        nearest.cwiseMin((places.colwise() - places.col(farthest)).colwise().norm().transpose());
  }
  basis.centers = places(Eigen::all, chosen);
  return basis;
}

}  // namespace planar
