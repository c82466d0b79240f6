#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/field/arm/arm_model.h"
#include "planar_servo/field/field_basis.h"
#include "planar_servo/field/lay_information.h"
#include "planar_servo/field/pose_sample.h"

namespace planar {

/// What a joint fit takes for granted. Lengths are in metres.
struct JointPriors {
  double field_width{0.13};      ///< of the field's Gaussians
  double field_sigma{1e-4};      ///< standard deviation of the field beside its quadratic
  double lamp_factor{1.0};       ///< times the stated deviations of the lamps' places
  double arm_sigma{1e-7};        ///< scatter of a pose about the arm's model, per axis
  double tool_sigma{3e-7};       ///< of the tool's direction about the arm's model, radians
  double air_sigma{1e-7};        ///< by which air displaces a picture of both lamps, per axis
  double deviation_sigma{1e-6};  ///< of the arm's smooth deviation over its postures, per axis
  double wave_sigma{1e-6};       ///< of the lamps' height beside its two terms
  double dot_factor{1.0};        ///< times the stated deviations of a board's dots
};

/// Holds the field, the arm and the tool that explain a set of poses, with their covariance. The
/// unknowns are the weights of the field's x with the drift along x, those of its y, and the
/// model's x.
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
/// only. Every sample counts as it is; nothing is left out. Empty when the equations cannot be
/// solved.
std::optional<JointFit> fit_jointly(const ArmModel& model, const JointPriors& priors,
                                    const std::vector<PoseSample>& samples, double field_radius,
                                    const LaidDots& board = {}, const Eigen::VectorXd& start = {});

/// Returns only the arm's unknowns of that fit, in less time.
std::optional<Eigen::VectorXd> arm_under(const ArmModel& model, const JointPriors& priors,
                                         const std::vector<PoseSample>& samples,
                                         double field_radius, const LaidDots& board);

/// Returns only the log likelihood of that fit, in less time.
std::optional<double> joint_log_likelihood(const ArmModel& model, const JointPriors& priors,
                                           const std::vector<PoseSample>& samples,
                                           double field_radius, const LaidDots& board = {});

}  // namespace planar
