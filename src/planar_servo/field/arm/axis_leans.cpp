#include "planar_servo/field/arm/axis_leans.h"

#include <array>
#include <cmath>
#include <optional>

#include "planar_servo/core/decompositions.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr Eigen::Index kUnknowns = 9;  // the leans, a height, and sag with |P|^2 and |P|^4

AxisLeans as_built(double above_m) {
  AxisLeans leans;
  // Joint 1 stands upright on its base to about 0.02 deg; the bores of a link are parallel to
  // 0.01 mm over 100 mm at worst, to a tenth of that where one clamping made them.
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

/// What heights tell of the unknowns if those have a prior.
struct Told {
  Eigen::VectorXd mean, variance;
  double log_evidence{0.0};
};

std::optional<Told> told_by(const Eigen::MatrixXd& A, const Eigen::VectorXd& z,
                            const Eigen::VectorXd& prior) {
  constexpr double kMedianOfOne = 0.6745;
  double noise = 1e-5;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(z.size());
  Told told;
  for (int round = 0; round < 4; ++round) {  // residuals tell the noise, and which are outliers
    const Eigen::MatrixXd weighed = (weights / (noise * noise)).asDiagonal() * A;
    Eigen::MatrixXd H = A.transpose() * weighed;
    H.diagonal() += prior.cwiseAbs2().cwiseInverse();
    const auto L = lower_factor(H);
    if (!L) return std::nullopt;
    const Eigen::MatrixXd inverse =
        L->triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(kUnknowns, kUnknowns));
    told.variance = inverse.colwise().squaredNorm();
    told.mean = inverse.transpose() * (inverse * (weighed.transpose() * z));
    const Eigen::VectorXd left = z - A * told.mean, far = left.cwiseAbs();
    told.log_evidence = -0.5 * left.dot(weights.cwiseProduct(z)) / (noise * noise) -
                        (L->diagonal().array() * prior.array()).log().sum() -
                        weights.sum() * std::log(noise);
    noise = median({far.begin(), far.end()}) / kMedianOfOne;
    weights = (far.array() < 4.0 * noise).cast<double>();
  }
  return told;
}

/// Returns the mean of the cases and its deviation, each case as likely as the heights make it.
AxisLeans mean_of(const std::vector<Told>& cases) {
  double total = 0.0;
  Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero(), square = mean;
  for (const Told& told : cases) {
    const double weight = std::exp(told.log_evidence - cases.front().log_evidence);
    total += weight;
    mean += weight * told.mean.head<6>();
    square += weight * (told.variance.head<6>() + told.mean.head<6>().cwiseAbs2());
  }
  mean /= total;
  return {mean, (square / total - mean.cwiseAbs2()).cwiseSqrt()};
}

}  // namespace

AxisLeans axis_leans(const ArmNominal& nominal, const std::vector<PoseSample>& samples) {
  const double above_m = std::abs(nominal.tool.p_TS.z());
  AxisLeans built = as_built(above_m);
  std::vector<const PoseSample*> read;
  for (const PoseSample& sample : samples)
    if (sample.reflector_B && sample.reflector_z) read.push_back(&sample);
  const auto n = static_cast<Eigen::Index>(read.size());
  if (n < 2 * kUnknowns || above_m < kMillimetre) return built;
  Eigen::MatrixXd A(n, kUnknowns);
  Eigen::VectorXd z(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    A.row(i) = height_row(nominal, *read[static_cast<std::size_t>(i)], above_m);
    z[i] = *read[static_cast<std::size_t>(i)]->reflector_z;
  }
  // Nobody knows how well the links are bored: the heights weigh what each case would tell.
  constexpr std::array<double, 3> kShares{0.1, 0.3, 1.0};
  constexpr double kAnyHeight = 1.0;
  std::vector<Told> cases;
  for (const double share : kShares) {
    Eigen::VectorXd prior = Eigen::VectorXd::Constant(kUnknowns, kAnyHeight);
    prior.head<6>() << built.sigma.head<2>(), share * built.sigma.tail<4>();
    auto told = told_by(A, z, prior);
    if (!told) return built;
    cases.push_back(std::move(*told));
  }
  return mean_of(cases);
}

}  // namespace planar
