#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/found_arm.h"

namespace planar {

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
