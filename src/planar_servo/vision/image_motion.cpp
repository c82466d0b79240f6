#include "planar_servo/vision/image_motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/core/decompositions.h"

namespace planar {
namespace {

using Design = Eigen::Matrix<double, 2, 6>;

constexpr std::size_t kLeastForAffine = 4;  // three leave no residual
constexpr double kLeastRcond = 1e-14;       // of normal equations in scaled unknowns

/// Returns d(now) / dp at a place of then.
Design design_at(const Eigen::Vector2d& r) {
  Design J = Design::Zero();
  J.leftCols<2>().setIdentity();
  J.block<1, 2>(0, 2) = r.transpose();
  J.block<1, 2>(1, 4) = r.transpose();
  return J;
}

/// Returns dp / dq for the unknowns q = (t_u, t_v, scale, turn) of a similarity, M = scale I +
/// turn [[0, -1], [1, 0]].
Eigen::MatrixXd similarity_basis() {
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(6, 4);
  basis(0, 0) = basis(1, 1) = 1.0;
  basis(2, 2) = basis(5, 2) = 1.0;
  basis(3, 3) = -1.0;
  basis(4, 3) = 1.0;
  return basis;
}

/// Returns the length of the farthest place, by which the unknowns of M are scaled.
double reach_px(const std::vector<LampMove>& moves) {
  double reach = 1.0;
  for (const LampMove& move : moves) reach = std::max(reach, move.then_px.norm());
  return reach;
}

/// Fits p = basis q. The first two unknowns of q are the shift.
std::optional<MotionFit> fit_motion(const std::vector<LampMove>& moves, Eigen::MatrixXd basis) {
  const auto n = static_cast<Eigen::Index>(moves.size()), unknowns = basis.cols();
  if (2 * n < unknowns) return std::nullopt;
  basis.rightCols(unknowns - 2) /= reach_px(moves);
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(unknowns);
  for (const LampMove& move : moves) {
    const Eigen::MatrixXd A = design_at(move.then_px) * basis;
    const Eigen::MatrixXd weighted = A.transpose() * move.covariance_px2.inverse();
    N += weighted * A;
    rhs += weighted * (move.now_px - move.then_px);
  }
  const auto cofactors =
      solve_positive(N, Eigen::MatrixXd::Identity(unknowns, unknowns), kLeastRcond);
  if (!cofactors) return std::nullopt;
  MotionFit result;
  result.motion = {basis * *cofactors * rhs, basis * *cofactors * basis.transpose()};
  for (const LampMove& move : moves) {
    const Eigen::Vector2d residual = move.now_px - result.motion.now(move.then_px);
    result.residuals_px.push_back(residual);
    result.chi2 += residual.dot(move.covariance_px2.inverse() * residual);
  }
  result.freedom = static_cast<int>(2 * n - unknowns);
  return result;
}

}  // namespace

Eigen::Vector2d ImageMotion::now(const Eigen::Vector2d& then_px) const {
  return then_px + design_at(then_px) * p_;
}

Eigen::Vector2d ImageMotion::then(const Eigen::Vector2d& now_px) const {
  Eigen::Matrix2d A;
  A << 1.0 + p_[2], p_[3], p_[4], 1.0 + p_[5];
  return A.inverse() * (now_px - p_.head<2>());
}

Eigen::Matrix2d ImageMotion::covariance_px2(const Eigen::Vector2d& then_px) const {
  const Design J = design_at(then_px);
  return J * covariance_ * J.transpose();
}

ImageMotion ImageMotion::towards(const ImageMotion& other, double part) const {
  const double rest = 1.0 - part;
  return {rest * p_ + part * other.p_, rest * rest * covariance_ + part * part * other.covariance_};
}

bool MotionFit::holds() const {
  return chi2 <= greatest_chi2(freedom);
}

std::optional<MotionFit> fit_similarity(const std::vector<LampMove>& moves) {
  return fit_motion(moves, similarity_basis());
}

std::optional<MotionFit> fit_affine(const std::vector<LampMove>& moves) {
  return fit_motion(moves, Eigen::MatrixXd::Identity(6, 6));
}

std::optional<MotionFit> fit_image_motion(const std::vector<LampMove>& moves) {
  auto similarity = fit_similarity(moves);
  if (!similarity || similarity->holds() || moves.size() < kLeastForAffine) return similarity;
  auto affine = fit_affine(moves);
  return affine && affine->holds() ? affine : similarity;
}

double greatest_chi2(int freedom) {
  if (freedom == 0) return std::numeric_limits<double>::infinity();
  const double part = 2.0 / (9.0 * freedom);
  return freedom * std::pow(1.0 - part + kMotionSigmas * std::sqrt(part), 3);
}

}  // namespace planar
