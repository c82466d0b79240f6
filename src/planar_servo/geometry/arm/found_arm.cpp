#include "planar_servo/geometry/arm/found_arm.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "planar_servo/base/core/decompositions.h"

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

/// Returns the frame in which the runout of axis 3 stands still.
Eigen::Matrix2d runout_frame(const Eigen::Vector3d& psi) {
  return rotation2d(2.0 * psi[1] - psi[2]);
}

/// Smooth deviations that a fit did not find are assumed to be half as large as the scatter.
constexpr double kUnseenShare = 0.5;
// In an hour's work links grow like aluminium warmed by some 4 degrees, and zeros shift by 20 um at
// 0.5 m; bearings wear over months.
constexpr double kGrowthPerHour = 100e-6;
constexpr double kTurnPerHour = 0.002 * kDegree;
constexpr double kWearPerHour_m = 1e-6;
/// A look with a smaller chance teaches nothing.
constexpr double kLeastChance = 1e-3;

/// Returns the covariance of the Gaussians' weights of a function of unit variance.
Eigen::MatrixXd unit_weights(const PostureBasis& posture) {
  const Eigen::Index m = posture.terms();
  const auto inverse = solve_positive(posture.kernel_matrix(), Eigen::MatrixXd::Identity(m, m));
  if (!inverse) throw std::invalid_argument("Gaussians over the posture are not apart");
  return *inverse;
}

/// Adds the covariance of a smooth deviation of both axes.
void add_deviation(Eigen::MatrixXd& covariance, const ArmForm& form, double sigma_m) {
  const Eigen::Index m = form.posture.terms();
  if (m == 0) return;
  const Eigen::MatrixXd weights = sigma_m * sigma_m * unit_weights(form.posture);
  for (const Eigen::Index first : {form.deviation(), form.deviation() + m})
    covariance.block(first, first, m, m) += weights;
}

/// Returns the terms of an arm as it was found in a form that may have more Gaussians.
Eigen::VectorXd found_terms(const FoundArm& found, const ArmForm& form) {
  if (found.form.waves() != form.waves())
    throw std::invalid_argument("what was learned is of another kind of arm");
  Eigen::VectorXd x = Eigen::VectorXd::Zero(form.terms());
  if (found.form.posture.terms() == form.posture.terms()) return found.x;
  x.head(form.deviation()) = found.x.head(form.deviation());
  return x;
}

/// Returns `turned` with the turns that the waves of these terms add to each motor.
Eigen::Array3d with_waves(Eigen::Array3d turned, const ArmForm& form, const Eigen::Vector3d& motors,
                          const Eigen::VectorXd& x) {
  for (int wave = 0; wave < form.waves(); ++wave) {
    const Eigen::Array3d angle = form.orders(wave) * motors.array();
    const Eigen::Index first = ArmForm::kFirstWave + Eigen::Index{6} * wave;
    turned +=
        x.segment<3>(first).array() * angle.sin() + x.segment<3>(first + 3).array() * angle.cos();
  }
  return turned;
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
  for (Eigen::Index i = 0; i < n; ++i) places.col(i) = coordinates(postures[i]);
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
  const Eigen::Array3d turned = with_waves(motors + x.segment<3>(2), *this, motors, x);
  return sense * (joints_per_motor * turned.matrix());
}

TipPose ArmForm::tip(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const {
  const Eigen::Vector3d psi = directions(motors, x);
  TipPose tip{x[0] * rotation2d(psi[0]).col(0) + x[1] * rotation2d(psi[1]).col(0), psi[2]};
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
  J.col(0).head<2>() = rotation2d(psi[0]).col(0);
  J.col(1).head<2>() = rotation2d(psi[1]).col(0);
  Eigen::Matrix3d by_psi = Eigen::Matrix3d::Zero();
  by_psi.col(0).head<2>() = x[0] * rotation2d(psi[0]).col(1);
  by_psi.col(1).head<2>() = x[1] * rotation2d(psi[1]).col(1);
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

Eigen::MatrixXd hourly_drift(const FoundArm& arm) {
  const Eigen::Index n = arm.form.terms();
  Eigen::MatrixXd drift = Eigen::MatrixXd::Zero(n, n);
  drift.diagonal().head<2>() = (kGrowthPerHour * arm.link_lengths_m()).cwiseAbs2();
  drift.diagonal().segment<3>(2).setConstant(kTurnPerHour * kTurnPerHour);
  add_deviation(drift, arm.form, kWearPerHour_m);
  return drift;
}

LearnedArm not_yet_learned(FoundArm found, const std::vector<Joints>& postures) {
  const PostureBasis posture =
      postures.empty() ? PostureBasis{} : basis_over_postures(postures, found.form.posture.width);
  return unlearned(std::move(found), posture);
}

LearnedArm unlearned(FoundArm found, const PostureBasis& posture) {
  const bool is_new = found.form.posture.terms() == 0 && posture.terms() > 0;
  if (is_new) {
    found.form.posture = posture;
    const Eigen::Index n = found.form.terms();
    found.x.conservativeResizeLike(Eigen::VectorXd::Zero(n));
    found.factor.conservativeResizeLike(Eigen::MatrixXd::Zero(n, found.factor.cols()));
  }
  Eigen::MatrixXd covariance = found.factor * found.factor.transpose();
  if (is_new) add_deviation(covariance, found.form, kUnseenShare * found.scatter_m);
  return {std::move(found), covariance};
}

ArmLearner::ArmLearner(const FoundArm& found, LearnedArm start)
    : found_x_(found_terms(found, start.arm.form)),
      learned_(std::move(start)),
      drift_(hourly_drift(learned_.arm)),
      kernel_(learned_.arm.form.posture.kernel_matrix()),
      t_s_(std::numeric_limits<double>::quiet_NaN()) {
  const Eigen::Index n = found_x_.size();
  const FoundArm& arm = learned_.arm;
  if (arm.x.size() != n || learned_.covariance.rows() != n || learned_.covariance.cols() != n ||
      arm.factor.rows() != n || arm.factor.cols() != found.factor.cols())
    throw std::invalid_argument("what was learned is of another arm");
  learned_.covariance += drift_;
}

double ArmLearner::hours_since(double t_s) const {
  return std::isnan(t_s_) ? 0.0 : std::max(0.0, t_s - t_s_) / kHour;
}

Lesson ArmLearner::take(const ArmLook& look, double t_s) {
  learned_.covariance += hours_since(t_s) * drift_;
  t_s_ = t_s;
  FoundArm& arm = learned_.arm;
  const Eigen::Matrix2Xd J = arm.form.jacobian(look.motors, arm.x).topRows<2>();
  const Eigen::MatrixX2d with_sight = learned_.covariance.lazyProduct(J.transpose()) +
                                      arm.factor.lazyProduct(look.vision_rows.transpose());
  const Eigen::Matrix2Xd vision_with_sight = J.lazyProduct(arm.factor) + look.vision_rows;
  Eigen::Matrix2d sight =
      J.lazyProduct(with_sight) + look.vision_rows.lazyProduct(vision_with_sight.transpose());
  sight.diagonal().array() += look.sigma_m * look.sigma_m;
  const Eigen::Matrix2d weight = sight.inverse();
  const Eigen::Vector2d innovation = look.p - arm.form.tip(look.motors, arm.x).p;
  if (!(std::exp(-0.5 * innovation.dot(weight * innovation)) >= kLeastChance))
    return Lesson::kUnexpected;
  const Eigen::MatrixX2d gain = with_sight * weight;
  const Eigen::VectorXd x = arm.x + gain * innovation;
  if (beyond_caps(look.motors, x)) return Lesson::kBeyondCaps;
  arm.x = x;
  Eigen::MatrixXd& covariance = learned_.covariance;
  covariance -= gain.lazyProduct(with_sight.transpose());
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  arm.factor -= gain.lazyProduct(vision_with_sight);
  ++lessons_;
  return Lesson::kTaken;
}

bool ArmLearner::beyond_caps(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const {
  const ArmForm& form = learned_.arm.form;
  const Eigen::VectorXd change = x - found_x_;
  const Eigen::Index m = form.posture.terms();
  if ((change.head<2>().array() / found_x_.head<2>().array()).abs().maxCoeff() > kMostGrowth)
    return true;
  // Zeros and waves may stand in for one another where a motor turns by less than a whole turn.
  const Eigen::Array3d turns = with_waves(change.segment<3>(2), form, motors, change);
  if (turns.abs().maxCoeff() > kMostTurn) return true;
  const Eigen::MatrixX2d deviation =
      kernel_.lazyProduct(change.tail(2 * m).reshaped(m, Eigen::Index{2}));
  return m > 0 && deviation.rowwise().norm().maxCoeff() > kMostDeviation_m;
}

Eigen::Matrix4d ArmLearner::landing_covariance(const Eigen::Vector3d& motors,
                                               const Eigen::Matrix2Xd& vision_rows,
                                               double t_s) const {
  const FoundArm& arm = learned_.arm;
  const Eigen::Matrix2Xd J = arm.form.jacobian(motors, arm.x).topRows<2>();
  const Eigen::Matrix2Xd by_term = J.lazyProduct(learned_.covariance + hours_since(t_s) * drift_),
                         by_number = J.lazyProduct(arm.factor);
  Eigen::Matrix4d covariance;
  covariance.topLeftCorner<2, 2>() = by_term.lazyProduct(J.transpose());
  covariance.topRightCorner<2, 2>() = by_number.lazyProduct(vision_rows.transpose());
  covariance.bottomLeftCorner<2, 2>() = covariance.topRightCorner<2, 2>().transpose();
  covariance.bottomRightCorner<2, 2>() = vision_rows.lazyProduct(vision_rows.transpose());
  return covariance;
}

}  // namespace planar
