#include "planar_servo/base/core/pose.h"

#include <Eigen/LU>
#include <stdexcept>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

namespace planar {

double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

double nearest_branch(double angle, double reference) {
  return reference + std::remainder(angle - reference, 2.0 * kPi);
}

Eigen::Matrix2d rotation2d(double angle) {
  return Eigen::Rotation2Dd(angle).toRotationMatrix();
}

Eigen::Matrix2Xd spiral_over_disc(double radius, Eigen::Index count) {
  const double golden_turn = kPi * (3.0 - std::sqrt(5.0)), n = static_cast<double>(count);
  Eigen::Matrix2Xd places(2, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto at = static_cast<double>(i);
    places.col(i) = radius * std::sqrt((at + 0.5) / n) * rotation2d(at * golden_turn).col(0);
  }
  return places;
}

Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

namespace {

// Points whose width over length is below this count as collinear: the turn about their line would
// be a hundred times less certain than the other turns.
constexpr double kLeastSpread = 1e-2;

template <int N>
using Points = Eigen::Matrix<double, N, Eigen::Dynamic>;

/// Returns whether the points determine a rigid motion, for which they must span N - 1 directions.
template <int N>
bool span_enough(const Points<N>& centred) {
  const Eigen::Matrix<double, N, N> scatter = centred.lazyProduct(centred.transpose());
  const Eigen::VectorXd squares = symmetric_eigenvalues(scatter);  // of the spread along each axis
  return squares(N - 1) > 0.0 && squares(1) > kLeastSpread * kLeastSpread * squares(N - 1);
}

template <int N>
Eigen::Transform<double, N, Eigen::Isometry> fit_rigid(const Points<N>& p_A, const Points<N>& p_B) {
  if (p_A.cols() != p_B.cols()) throw std::invalid_argument("point sets of different size");
  if (!p_A.allFinite() || !p_B.allFinite())
    throw InputError({"a point is not finite", "", "rigid fit"});
  if (p_A.cols() < N)
    throw InputError({std::to_string(p_A.cols()) + " points",
                      "at least " + std::to_string(N) + " are needed", "rigid fit",
                      Cause::kInsufficient});
  const Eigen::Vector<double, N> mean_A = p_A.rowwise().mean(), mean_B = p_B.rowwise().mean();
  const Points<N> centred_A = p_A.colwise() - mean_A, centred_B = p_B.colwise() - mean_B;
  if (!span_enough<N>(centred_A) || !span_enough<N>(centred_B))
    throw InputError({N == 2 ? "all points are in one place" : "the points lie on one line",
                      N == 2 ? "" : "move one of them off it", "rigid fit", Cause::kInsufficient});
  const SingularValues svd = singular_values(centred_B.lazyProduct(centred_A.transpose()));
  const Eigen::Matrix<double, N, N> U = svd.U, V = svd.V;
  Eigen::Vector<double, N> signs = Eigen::Vector<double, N>::Ones();
  signs(N - 1) = (V * U.transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  Eigen::Transform<double, N, Eigen::Isometry> X_AB;
  X_AB.linear() = V * signs.asDiagonal() * U.transpose();
  X_AB.translation() = mean_A - X_AB.linear() * mean_B;
  X_AB.makeAffine();
  return X_AB;
}

}  // namespace

Eigen::Isometry2d fit_rigid_2d(const Eigen::Matrix2Xd& p_A, const Eigen::Matrix2Xd& p_B) {
  return fit_rigid<2>(p_A, p_B);
}

Pose fit_rigid_3d(const Eigen::Matrix3Xd& p_A, const Eigen::Matrix3Xd& p_B) {
  return fit_rigid<3>(p_A, p_B);
}

}  // namespace planar
