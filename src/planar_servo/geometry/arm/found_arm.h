#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/geometry/arm/planar_arm.h"

namespace planar {

/// Gaussians over the postures of an arm. With u = (cos theta1, sin theta1, theta2 - theta1), in
/// which a whole turn of joint 1 leads back,
///
///     b_j(theta) = exp(-|u - c_j|^2 / (2 width^2)).
struct PostureBasis {
  Eigen::Matrix3Xd centers;
  double width{0.6};

  Eigen::Index terms() const { return centers.cols(); }
  Eigen::RowVectorXd at(const Joints& theta) const;
  /// Returns the matrix whose inverse is the prior covariance of the weights of a function of unit
  /// variance.
  Eigen::MatrixXd kernel_matrix() const;
};

/// Returns a basis of this width whose centres are some of these postures, spread evenly.
PostureBasis basis_over_postures(const std::vector<Joints>& postures, double width);

/// Says by which terms an arm differs from two links in a plane. With motor angles m (behind the
/// gears, radians), gear ratios N, the sense s and the coupling C of theory section 7,
///
///     o = m + z + sum_h (a_h sin(k m) + b_h cos(k m)),   psi = s C^-1 o,
///     P = L1 u(psi_1) + L2 u(psi_2) + sum_j b_j(C^-1 m) w_j + R(2 psi_2 - psi_3) c,
///
/// where k = 1, 2, ... for the harmonics of the turn behind the gear, then N, 2 N, ... for the
/// ripples of the motor's own turn, and b_j are the Gaussians over the posture. c is the runout of
/// axis 3 that turns against the tool; what turns with it is part of where P lies in the tool. The
/// terms x are, in this order: L1, L2, z (3), a_h and b_h of each wave (6), c (2), the x and the y
/// of all w_j.
struct ArmForm {
  double sense{1.0};
  Eigen::Matrix3d joints_per_motor{Eigen::Matrix3d::Identity()};  ///< C^-1
  Eigen::Vector3d gear_ratios{1.0, 1.0, 1.0};                     ///< motor turns per turn
  int harmonics{0};
  int ripples{0};
  PostureBasis posture{};

  int waves() const { return harmonics + ripples; }
  /// Returns k of a wave for each motor.
  Eigen::Array3d orders(int wave) const;

  static constexpr Eigen::Index kFirstWave = 5;
  Eigen::Index runout() const { return kFirstWave + Eigen::Index{6} * waves(); }
  Eigen::Index deviation() const { return runout() + 2; }
  Eigen::Index terms() const { return deviation() + 2 * posture.terms(); }

  /// Returns the end point and the direction psi_3 of the tool.
  TipPose tip(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const;

  /// d(P_x, P_y, psi_3) / dx.
  using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  Jacobian jacobian(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const;

 private:
  Eigen::Vector3d directions(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const;
};

/// An arm as its poses showed it.
struct FoundArm {
  ArmForm form;
  Eigen::VectorXd x{Eigen::VectorXd::Zero(7)};  ///< of form.terms()
  /// U of the covariance U U^T of x. Where a field was found together with the arm, its columns are
  /// those of the field's. Empty where nothing is known of it.
  Eigen::MatrixXd factor{};
  double scatter_m{0.0};  ///< by which a stop misses at random, standard deviation per axis
  double wander_m{0.0};   ///< by which its base moves slowly, standard deviation per axis

  Eigen::Vector2d link_lengths_m() const { return x.head<2>(); }
  TipPose tip(const Eigen::Vector3d& motors) const { return form.tip(motors, x); }
};

}  // namespace planar
