#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/learn/field/arm/arm_model.h"
#include "planar_servo/learn/field/field_basis.h"
#include "planar_servo/learn/field/lay_information.h"

namespace planar {

/// The priors of a joint fit. Lengths are in metres.
struct JointPriors {
  double field_width{0.13};      ///< of the field's Gaussians
  double field_sigma{1e-4};      ///< standard deviation of the field besides its quadratic
  double lamp_factor{1.0};       ///< times the stated deviations of the lamps' places
  double arm_sigma{1e-7};        ///< scatter of a pose about the arm's model, per axis
  double tool_sigma{3e-7};       ///< of the tool's direction about the arm's model, radians
  double air_sigma{1e-7};        ///< by which air displaces a picture of both lamps, per axis
  double deviation_sigma{1e-6};  ///< of the arm's smooth deviation over its postures, per axis
  double wave_sigma{1e-6};       ///< of the lamps' height besides its two terms
  double wander_sigma{1e-7};     ///< of the base's slow motion, per axis
  double dot_factor{1.0};        ///< times the stated deviations of a board's dots
};

/// Holds the field, arm and tool that explain a set of poses, with their covariance. Unknowns are
/// the weights of the field's x and the drift along x, those of its y, and the model's x.
struct JointFit {
  FieldBasis basis;
  Eigen::MatrixX2d weights;                 ///< of the field's x and y
  Eigen::Vector2d drift_m_per_h{0.0, 0.0};  ///< of where everything is seen
  Eigen::VectorXd arm;                      ///< x of the model
  Eigen::MatrixXd covariance;               ///< of all unknowns in this order
  double log_likelihood{0.0};  ///< marginal; comparable between fits of the same samples
  std::vector<double> chi2;    ///< of each sample's residual: four numbers, six with a reading

  /// Returns the number of unknowns of one component of the field, its drift last.
  Eigen::Index field_terms() const { return basis.terms() + 1; }
};

/// Estimates the field e, seen place = place + e + drift t, together with the arm and the tool, by
/// Gauss-Newton steps from `start` (or from the files' arm) with the priors as further observations
/// (theory section 13). The reflector and both lamps of a pose share its scatter about the arm's
/// model, and both lamps the air between them and the camera. The lays of a board tell the field
/// only. Nothing is left out. Empty when the equations cannot be solved.
std::optional<JointFit> fit_jointly(const ArmModel& model, const JointPriors& priors,
                                    const std::vector<PoseSample>& samples, double field_radius,
                                    const LaidDots& board = {}, const Eigen::VectorXd& start = {});

/// The equations by which a set of poses tells field, arm and tool, linearised about an arm. They
/// are built in stages, so that a search over the priors repeats only what a change requires: the
/// rows of the arm, those of the field of some width, their sums under some noise, and the solution
/// under some priors. The model, the samples and the board must outlive them.
class JointEquations {
 public:
  JointEquations(const ArmModel& model, const std::vector<PoseSample>& samples, double radius,
                 const LaidDots& board);

  void linearize(const Eigen::VectorXd& x);
  /// Solves under these priors. Returns whether the equations can be solved.
  bool solve(const JointPriors& priors);
  /// Linearises and solves in Gauss-Newton steps from `start`, or from the files' arm. Returns the
  /// arm's unknowns; empty when the steps do not converge.
  std::optional<Eigen::VectorXd> solve_in_steps(const JointPriors& priors,
                                                const Eigen::VectorXd& start = {});

  const FieldBasis& basis() const { return basis_; }
  /// Returns the weights and the drift of the field, x then y, and the step of the arm's unknowns.
  const Eigen::VectorXd& solution() const { return solution_; }
  Eigen::MatrixXd covariance() const;
  /// Returns log p(samples) but for a constant that depends on the number of samples only.
  double log_likelihood() const;
  /// Returns chi squared of each sample's residual: four numbers, six with a reading.
  std::vector<double> chi2() const;

 private:
  /// Weights of Gaussians among the unknowns, with their inverse prior for unit variance.
  struct SmoothTerms {
    Eigen::Index first;
    Eigen::MatrixXd kernel;
    double JointPriors::*sigma;
    double log_det;
  };

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
  std::vector<SmoothTerms> smooth_;
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
