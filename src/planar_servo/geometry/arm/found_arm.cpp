#include "planar_servo/geometry/arm/found_arm.h"

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

Eigen::Vector2d along(double psi) {
  return {std::cos(psi), std::sin(psi)};
}

Eigen::Vector2d across(double psi) {
  return {-std::sin(psi), std::cos(psi)};
}

/// Returns the frame in which the runout of axis 3 stands still.
Eigen::Matrix2d runout_frame(const Eigen::Vector3d& psi) {
  return rotation2d(2.0 * psi[1] - psi[2]);
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

Eigen::Array3d ArmForm::orders(int wave) const {
  if (wave < harmonics) return Eigen::Array3d::Constant(wave + 1.0);
  return (wave - harmonics + 1.0) * gear_ratios.array();
}

Eigen::Vector3d ArmForm::directions(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const {
  Eigen::Array3d turned = motors + x.segment<3>(2);
  for (int wave = 0; wave < waves(); ++wave) {
    const Eigen::Array3d angle = orders(wave) * motors.array();
    const Eigen::Index first = kFirstWave + Eigen::Index{6} * wave;
    turned +=
        x.segment<3>(first).array() * angle.sin() + x.segment<3>(first + 3).array() * angle.cos();
  }
  return sense * (joints_per_motor * turned.matrix());
}

TipPose ArmForm::tip(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const {
  const Eigen::Vector3d psi = directions(motors, x);
  TipPose tip{x[0] * along(psi[0]) + x[1] * along(psi[1]), psi[2]};
  tip.p += runout_frame(psi) * x.segment<2>(runout());
  if (posture.terms() > 0) {
    const Eigen::RowVectorXd b = posture.at(joints_per_motor * motors);
    tip.p.x() += b * x.segment(deviation(), posture.terms());
    tip.p.y() += b * x.tail(posture.terms());
  }
  return tip;
}

ArmForm::Jacobian ArmForm::jacobian(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const {
  const Eigen::Vector3d psi = directions(motors, x);
  Jacobian J = Jacobian::Zero(3, terms());
  J.col(0).head<2>() = along(psi[0]);
  J.col(1).head<2>() = along(psi[1]);
  Eigen::Matrix3d by_psi = Eigen::Matrix3d::Zero();
  by_psi.col(0).head<2>() = x[0] * across(psi[0]);
  by_psi.col(1).head<2>() = x[1] * across(psi[1]);
  by_psi(2, 2) = 1.0;
  const Eigen::Matrix3d by_motor = sense * by_psi * joints_per_motor;
  J.middleCols<3>(2) = by_motor;
  for (int wave = 0; wave < waves(); ++wave) {
    const Eigen::Array3d angle = orders(wave) * motors.array();
    const Eigen::Index first = kFirstWave + Eigen::Index{6} * wave;
    J.middleCols<3>(first) = by_motor * angle.sin().matrix().asDiagonal();
    J.middleCols<3>(first + 3) = by_motor * angle.cos().matrix().asDiagonal();
  }
  // The runout turns with the directions by less than a part in a thousand.
  J.middleCols<2>(runout()).topRows<2>() = runout_frame(psi);
  if (posture.terms() > 0) {
    const Eigen::RowVectorXd b = posture.at(joints_per_motor * motors);
    J.row(0).segment(deviation(), posture.terms()) = b;
    J.row(1).tail(posture.terms()) = b;
  }
  return J;
}

}  // namespace planar
