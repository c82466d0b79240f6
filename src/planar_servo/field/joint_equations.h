#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/field/joint_fit.h"

namespace planar {

/// The equations by which a set of poses tells field, arm and tool, linearised about an arm. They
/// are built in stages, so that a search over the priors repeats only what a change asks for: the
/// rows of the arm, those of the field of some width, their sums under some noise, and the solution
/// under some priors. The model, the samples and the board must outlive them.
class JointEquations {
 public:
  JointEquations(const ArmModel& model, const std::vector<PoseSample>& samples, double radius,
                 const LaidDots& board);

  void linearize(const Eigen::VectorXd& x);
  /// Solves under these priors. Returns whether the equations can be solved.
  bool solve(const JointPriors& priors);

  const FieldBasis& basis() const { return basis_; }
  /// Returns the weights and the drift of the field, x then y, and the step of the arm's unknowns.
  const Eigen::VectorXd& solution() const { return solution_; }
  Eigen::MatrixXd covariance() const;
  /// Returns log p(samples) but for a constant that depends on the number of samples only.
  double log_likelihood() const;
  /// Returns chi squared of each sample's residual: four numbers, six with a reading.
  std::vector<double> chi2() const;

 private:
  static constexpr int kRows = 6;  // of a pose: reflector, lamp 1, lamp 2
  using PoseRows = Eigen::Matrix<double, kRows, 1>;
  using PoseWeight = Eigen::Matrix<double, kRows, kRows>;

  Eigen::Index field_terms() const { return 2 * (basis_.terms() + 1); }
  Eigen::Index terms() const { return field_terms() + model_.terms(); }
  PoseWeight whitening_of(const PoseSample& sample, const JointPriors& priors);
  void set_width(double width);
  void weigh(const JointPriors& priors);
  void add_priors(const JointPriors& priors);

  const ArmModel& model_;
  const std::vector<PoseSample>& samples_;
  const double radius_;
  const LaidDots& board_;
  const Eigen::VectorXd nominal_, sigma_;
  const Eigen::MatrixXd posture_kernel_, wave_kernel_;
  const double posture_log_det_, wave_log_det_;
  Eigen::VectorXd x_;
  FieldBasis basis_;
  Eigen::MatrixXd kernel_;
  double kernel_log_det_{0.0};
  JointPriors weighed_by_;  ///< whose noise is in the sums
  bool weighed_{false};
  Eigen::MatrixXd F_, J_, A_;    ///< rows of the field and of the arm, and both whitened
  Eigen::VectorXd z_, z_white_;  ///< residuals but for the field
  LayInformation told_;          ///< by the board
  Eigen::MatrixXd S_, H_, L_;
  Eigen::VectorXd s_, half_, solution_;
  double squares_{0.0}, noise_log_det_{0.0}, prior_squares_{0.0}, prior_log_det_{0.0};
};

}  // namespace planar
