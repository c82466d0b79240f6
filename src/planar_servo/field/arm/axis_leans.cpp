#include "planar_servo/field/arm/axis_leans.h"

#include <cmath>

#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr Eigen::Index kUnknowns = 9;  // the leans, a height, and sag with |P|^2 and |P|^4

AxisLeans as_built(double above_m) {
  AxisLeans leans;
  // Joint 1 stands upright on its base to about 0.02 deg; a link is bored for its axes parallel to
  // 0.01 mm over 100 mm.
  leans.sigma.head<2>().setConstant(0.02 * kDegree * above_m);
  leans.sigma.tail<4>().setConstant(1e-4 * above_m);
  return leans;
}

/// Returns d(height of the reflector) / d(unknowns).
Eigen::Matrix<double, 1, kUnknowns> height_row(const ArmNominal& nominal, const PoseSample& sample,
                                               double above_m) {
  const double sense = PlanarArm(nominal.geometry).sense();
  const Eigen::Vector3d psi = sense * nominal.joints_per_motor * sample.motors;
  const Eigen::Matrix2d link1 = rotation2d(psi[0]), link2 = rotation2d(psi[1]);
  const Eigen::Vector2d elbow = nominal.geometry.link_lengths_m[0] * link1.col(0);
  const Eigen::Vector2d tip = elbow + nominal.geometry.link_lengths_m[1] * link2.col(0);
  const Eigen::Vector2d p = *sample.reflector_B;
  const double r2 = tip.squaredNorm();
  Eigen::Matrix<double, 1, kUnknowns> row;
  row << -p.transpose() / above_m, -(p - elbow).transpose() * link1 / above_m,
      -(p - tip).transpose() * link2 / above_m, 1.0, r2, r2 * r2;
  return row;
}

}  // namespace

AxisLeans axis_leans(const ArmNominal& nominal, const std::vector<PoseSample>& samples) {
  const double above_m = std::abs(nominal.tool.p_TS.z());
  AxisLeans leans = as_built(above_m);
  std::vector<const PoseSample*> read;
  for (const PoseSample& sample : samples)
    if (sample.reflector_B && sample.reflector_z) read.push_back(&sample);
  const auto n = static_cast<Eigen::Index>(read.size());
  if (n < 2 * kUnknowns || above_m < kMillimetre) return leans;
  Eigen::MatrixXd A(n, kUnknowns);
  Eigen::VectorXd z(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    A.row(i) = height_row(nominal, *read[static_cast<std::size_t>(i)], above_m);
    z[i] = *read[static_cast<std::size_t>(i)]->reflector_z;
  }
  constexpr double kAnyHeight = 1.0, kMedianOfOne = 0.6745;
  Eigen::VectorXd prior = Eigen::VectorXd::Constant(kUnknowns, kAnyHeight);
  prior.head<6>() = leans.sigma;
  double noise = 1e-5;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(n);
  for (int round = 0; round < 4; ++round) {  // residuals tell the noise, and which are outliers
    const Eigen::MatrixXd weighed = (weights / (noise * noise)).asDiagonal() * A;
    Eigen::MatrixXd H = A.transpose() * weighed;
    H.diagonal() += prior.cwiseAbs2().cwiseInverse();
    const auto covariance = solve_positive(H, Eigen::MatrixXd::Identity(kUnknowns, kUnknowns));
    if (!covariance) return leans;
    const Eigen::VectorXd x = *covariance * (weighed.transpose() * z);
    leans.shift = x.head<6>();
    leans.sigma = covariance->diagonal().head<6>().cwiseSqrt();
    const Eigen::VectorXd left = (z - A * x).cwiseAbs();
    noise = median({left.begin(), left.end()}) / kMedianOfOne;
    weights = (left.array() < 4.0 * noise).cast<double>();
  }
  return leans;
}

}  // namespace planar
