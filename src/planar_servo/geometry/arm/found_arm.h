#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/base/core/units.h"
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

/// An arm as looks at it have shown it since it was found.
struct LearnedArm {
  /// The arm as expected. The columns of its factor are the covariances of its terms with those
  /// numbers of unit variance that the columns of the field's factor are multiplied with.
  FoundArm arm;
  Eigen::MatrixXd covariance;  ///< of the arm's terms
};

/// Returns an arm as it was found, with a factor that has the columns of the field's. Where its
/// form has no Gaussians over the posture it is given some, spread over these postures: smooth
/// deviations that were too small to be found beside the scatter may be learned.
LearnedArm not_yet_learned(FoundArm found, const std::vector<Joints>& postures);
/// The same with these Gaussians.
LearnedArm unlearned(FoundArm found, const PostureBasis& posture);

struct ArmLook {
  Eigen::Vector3d motors{0.0, 0.0, 0.0};
  Eigen::Vector2d p{0.0, 0.0};  ///< where vision, compensated, sees the end point
  /// The error of `p` is these rows times the numbers of unit variance.
  Eigen::Matrix2Xd vision_rows;
  double sigma_m{0.0};  ///< of scatter and noise together, per axis
};

/// Says what became of a look.
enum class Lesson {
  kTaken,
  kUnexpected,  ///< what is known leaves less than one chance in a thousand for it
  kBeyondCaps,  ///< it implies an arm that neither warmth nor wear makes of the one found
};

/// Returns the covariance of the change of an arm's terms in an hour's work.
Eigen::MatrixXd hourly_drift(const FoundArm& arm);

/// Learns the terms of an arm from looks, one after the other. It is a Kalman filter that considers
/// the error of vision (a Schmidt filter): looks at one place share that error, which is neither
/// learned nor attributed to the arm. Links and zeros drift with the motors' warmth, the smooth
/// deviation with wear.
class ArmLearner {
 public:
  /// Continues from `start`, since when the arm may have warmed or cooled as in an hour. Both have
  /// the same waves and as many columns in their factors; else std::invalid_argument.
  ArmLearner(const FoundArm& found, LearnedArm start);

  Lesson take(const ArmLook& look, double t_s);

  /// Returns the covariance of (d, v) at time t_s: of the arm's miss with these motors, and of the
  /// error of vision by these rows.
  Eigen::Matrix4d landing_covariance(const Eigen::Vector3d& motors,
                                     const Eigen::Matrix2Xd& vision_rows, double t_s) const;

  const LearnedArm& learned() const { return learned_; }
  int lessons() const { return lessons_; }  ///< looks that were taken

  // Limits that no look may exceed. Aluminium grows by 23 um/m and degree; the motors of a small
  // arm warm its links by 3 to 15 degrees.
  static constexpr double kMostGrowth = 350e-6;
  /// Zero and waves together may turn a motor by this much at the posture of a look: bearings and
  /// reducers shift with warmth by some thousandths of a degree.
  static constexpr double kMostTurn = 0.01 * kDegree;
  /// Smooth deviations change by wear and by loads; more than this requires a new calibration.
  static constexpr double kMostDeviation_m = 0.1e-3;

 private:
  double hours_since(double t_s) const;
  bool beyond_caps(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const;

  Eigen::VectorXd found_x_;  ///< in the form of what is learned
  LearnedArm learned_;
  Eigen::MatrixXd drift_;   ///< covariance of the terms' change in an hour
  Eigen::MatrixXd kernel_;  ///< of the posture's Gaussians
  double t_s_;              ///< until which drift is in the covariance; NaN before the first look
  int lessons_{0};
};

}  // namespace planar
