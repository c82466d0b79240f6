#include "planar_servo/field/joint_fit.h"

#include <limits>

#include "planar_servo/field/joint_equations.h"

namespace planar {
namespace {

constexpr int kMostSteps = 8;
/// Steps smaller than this share of the prior deviations end the iteration.
constexpr double kSmallStep = 1e-4;

/// Returns the arm's unknowns; empty when the steps do not converge.
std::optional<Eigen::VectorXd> solve_in_steps(JointEquations& equations, const ArmModel& model,
                                              const JointPriors& priors,
                                              const Eigen::VectorXd& start) {
  Eigen::VectorXd x = start.size() > 0 ? start : model.nominal();
  // The Gaussians' weights balance each other by much more than the function that they make.
  constexpr double kAnySize = std::numeric_limits<double>::infinity();
  Eigen::VectorXd size = model.prior_sigma();
  size.segment(model.form().deviation(), 2 * model.form().posture.terms()).setConstant(kAnySize);
  const Eigen::Index waves = model.height().wave.centers.cols();
  size.segment(model.layout().tool - waves, waves).setConstant(kAnySize);
  for (int step = 0; step < kMostSteps; ++step) {
    equations.linearize(x);
    if (!equations.solve(priors)) return std::nullopt;
    const Eigen::VectorXd dx = equations.solution().tail(model.terms());
    x += dx;
    if ((dx.array() / size.array()).abs().maxCoeff() < kSmallStep) return x;
  }
  return std::nullopt;
}

}  // namespace

std::optional<JointFit> fit_jointly(const ArmModel& model, const JointPriors& priors,
                                    const std::vector<PoseSample>& samples, double field_radius,
                                    const LaidDots& board, const Eigen::VectorXd& start) {
  JointEquations equations(model, samples, field_radius, board);
  const auto x = solve_in_steps(equations, model, priors, start);
  if (!x) return std::nullopt;
  JointFit fit;
  fit.basis = equations.basis();
  const Eigen::Index nb = fit.basis.terms();
  const Eigen::MatrixX2d of_field =
      equations.solution().head(2 * fit.field_terms()).reshaped(nb + 1, 2);
  fit.weights = of_field.topRows(nb);
  fit.drift_m_per_h = of_field.row(nb);
  fit.arm = *x;
  fit.covariance = equations.covariance();
  fit.log_likelihood = equations.log_likelihood();
  fit.chi2 = equations.chi2();
  return fit;
}

std::optional<Eigen::VectorXd> arm_under(const ArmModel& model, const JointPriors& priors,
                                         const std::vector<PoseSample>& samples,
                                         double field_radius, const LaidDots& board) {
  JointEquations equations(model, samples, field_radius, board);
  return solve_in_steps(equations, model, priors, {});
}

std::optional<double> joint_log_likelihood(const ArmModel& model, const JointPriors& priors,
                                           const std::vector<PoseSample>& samples,
                                           double field_radius, const LaidDots& board) {
  JointEquations equations(model, samples, field_radius, board);
  if (!solve_in_steps(equations, model, priors, {})) return std::nullopt;
  return equations.log_likelihood();
}

}  // namespace planar
