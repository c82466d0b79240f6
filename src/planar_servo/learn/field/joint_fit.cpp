#include "planar_servo/learn/field/joint_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/decompositions.h"

namespace planar {
namespace {

constexpr int kMostSteps = 8;
/// Steps smaller than this share of the prior deviations end the iteration.
constexpr double kSmallStep = 1e-4;

/// Prior deviation of each term of the field's quadratic, metres.
constexpr double kQuadraticSigma = 1e-3;
/// Prior deviation of the camera's drift along an axis, metres an hour.
constexpr double kDriftSigma = 30e-6;

double log_det_of(const Eigen::MatrixXd& lower) {
  return 2.0 * lower.diagonal().array().log().sum();
}

double log_det_of_kernel(const Eigen::MatrixXd& kernel) {
  return kernel.size() == 0 ? 0.0 : log_det_of(*lower_factor(kernel));
}

bool same_noise(const JointPriors& a, const JointPriors& b) {
  return a.lamp_factor == b.lamp_factor && a.arm_sigma == b.arm_sigma &&
         a.tool_sigma == b.tool_sigma && a.air_sigma == b.air_sigma && a.dot_factor == b.dot_factor;
}

}  // namespace

JointEquations::JointEquations(const ArmModel& model, const std::vector<PoseSample>& samples,
                               double radius, const LaidDots& board)
    : model_(model),
      samples_(samples),
      radius_(radius),
      board_(board),
      nominal_(model.nominal()),
      sigma_(model.prior_sigma()) {
  const auto add = [&](Eigen::Index first, const Eigen::MatrixXd& kernel, int components,
                       double JointPriors::*sigma) {
    const double log_det = log_det_of_kernel(kernel);
    for (int i = 0; i < components; ++i)
      smooth_.push_back({first + i * kernel.rows(), kernel, sigma, log_det});
  };
  const auto at = model.layout();
  const Eigen::MatrixXd wave = model.height().wave.kernel_matrix();
  add(model.form().deviation(), model.form().posture.kernel_matrix(), 2,
      &JointPriors::deviation_sigma);
  add(at.wander, model.size().wander.kernel_matrix(), 2, &JointPriors::wander_sigma);
  add(at.tool - wave.rows(), wave, 1, &JointPriors::wave_sigma);
  linearize(nominal_);
}

void JointEquations::linearize(const Eigen::VectorXd& x) {
  x_ = x;
  const auto n = static_cast<Eigen::Index>(samples_.size());
  J_.resize(kRows * n, model_.terms());
  z_.resize(kRows * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const PoseSample& sample = samples_[static_cast<std::size_t>(i)];
    const ToolPoints at = model_.at(sample, x);
    J_.middleRows<kRows>(kRows * i) = model_.jacobian(sample, x);
    z_.segment<kRows>(kRows * i) << sample.reflector_B.value_or(at.points.col(0)) -
                                        at.points.col(0),
        sample.lamps_B[0] - at.points.col(1), sample.lamps_B[1] - at.points.col(2);
  }
  weighed_ = false;
}

void JointEquations::set_width(double width) {
  basis_ = basis_over_disc(radius_, width);
  kernel_ = basis_.kernel_matrix();
  kernel_log_det_ = log_det_of_kernel(kernel_);
  const Eigen::Index nb = basis_.terms();
  F_ = Eigen::MatrixXd::Zero(J_.rows(), field_terms());
  for (std::size_t i = 0; i < samples_.size(); ++i)
    for (std::size_t lamp = 0; lamp < 2; ++lamp) {
      Eigen::RowVectorXd b(nb + 1);
      b << basis_.at(samples_[i].lamps_B[lamp]), samples_[i].t_h;
      const auto row = static_cast<Eigen::Index>(kRows * i + 2 + 2 * lamp);
      F_.row(row).head(nb + 1) = b;
      F_.row(row + 1).tail(nb + 1) = b;
    }
  weighed_ = false;
}

/// Rows of the result times a pose's residuals have unit variance. Reflector and lamps share the
/// scatter of the pose, a shift of the end point and a turn about it; the lamps share the air.
JointEquations::PoseWeight JointEquations::whitening_of(const PoseSample& sample,
                                                        const JointPriors& priors) {
  const Eigen::Index first = sample.reflector_B ? 0 : 2;
  const Eigen::Index n = (sample.lamps_seen ? kRows : 2) - first;
  const ToolPoints seen = model_.at(sample, nominal_);
  const double lamp = priors.lamp_factor * sample.sigma_lamp;
  PoseRows variance = PoseRows::Constant(lamp * lamp);
  variance.head<2>().setConstant(sample.sigma_reflector * sample.sigma_reflector);
  Eigen::Matrix<double, kRows, 5> shared = Eigen::Matrix<double, kRows, 5>::Zero();
  for (Eigen::Index point = 0; point < 3; ++point) {
    const Eigen::Vector2d offset = seen.points.col(point) - seen.tip.p;
    auto rows = shared.middleRows<2>(2 * point);
    rows.leftCols<3>() << priors.arm_sigma, 0.0, -priors.tool_sigma * offset.y(), 0.0,
        priors.arm_sigma, priors.tool_sigma * offset.x();
    if (point > 0) rows.rightCols<2>() = priors.air_sigma * Eigen::Matrix2d::Identity();
  }
  PoseWeight covariance = shared * shared.transpose();
  covariance.diagonal() += variance;
  const Eigen::MatrixXd L = *lower_factor(covariance.block(first, first, n, n));
  noise_log_det_ += log_det_of(L);
  PoseWeight whiten = PoseWeight::Zero();
  whiten.block(first, first, n, n) = inverse_of_lower(L);
  return whiten;
}

void JointEquations::weigh(const JointPriors& priors) {
  A_.resize(J_.rows(), terms());
  z_white_.resize(J_.rows());
  noise_log_det_ = 0.0;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const PoseWeight whiten = whitening_of(samples_[i], priors);
    const auto row = static_cast<Eigen::Index>(kRows * i);
    A_.middleRows<kRows>(row).leftCols(field_terms()).noalias() =
        whiten * F_.middleRows<kRows>(row);
    A_.middleRows<kRows>(row).rightCols(model_.terms()).noalias() =
        whiten * J_.middleRows<kRows>(row);
    z_white_.segment<kRows>(row) = whiten * z_.segment<kRows>(row);
  }
  S_ = Eigen::MatrixXd::Zero(terms(), terms());
  if (A_.rows() > 0)  // Eigen divides by the number of rows
    S_.selfadjointView<Eigen::Lower>().rankUpdate(A_.transpose());
  s_ = A_.transpose() * z_white_;
  squares_ = z_white_.squaredNorm();
  told_ = lay_information(board_, basis_, priors.dot_factor);
  const Eigen::Index nb = basis_.terms();
  for (const Eigen::Index row : {0, 1}) {
    for (const Eigen::Index column : {0, 1})
      S_.block(row * (nb + 1), column * (nb + 1), nb, nb) +=
          told_.H.block(row * nb, column * nb, nb, nb);
    s_.segment(row * (nb + 1), nb) += told_.right.segment(row * nb, nb);
  }
  weighed_by_ = priors;
  weighed_ = true;
}

void JointEquations::add_priors(const JointPriors& priors) {
  H_ = S_;
  half_ = s_;
  prior_squares_ = prior_log_det_ = 0.0;
  const auto add_diagonal = [&](Eigen::Index i, double sigma, double off) {
    H_(i, i) += 1.0 / (sigma * sigma);
    half_[i] += off / (sigma * sigma);
    prior_squares_ += off * off / (sigma * sigma);
    prior_log_det_ -= 2.0 * std::log(sigma);
  };
  const auto add_kernel = [&](Eigen::Index first, const Eigen::MatrixXd& kernel, double log_det,
                              double sigma, const Eigen::VectorXd& off) {
    const Eigen::Index n = kernel.rows();
    const Eigen::VectorXd pull = kernel * off / (sigma * sigma);
    H_.block(first, first, n, n) += kernel / (sigma * sigma);
    half_.segment(first, n) += pull;
    prior_squares_ += off.dot(pull);
    prior_log_det_ += log_det - 2.0 * static_cast<double>(n) * std::log(sigma);
  };
  const Eigen::Index nb = basis_.terms(), nc = basis_.centers.cols();
  for (const Eigen::Index first : {Eigen::Index{0}, nb + 1}) {
    add_kernel(first, kernel_, kernel_log_det_, priors.field_sigma, Eigen::VectorXd::Zero(nc));
    for (Eigen::Index i = nc; i < nb; ++i) add_diagonal(first + i, kQuadraticSigma, 0.0);
    add_diagonal(first + nb, kDriftSigma, 0.0);
  }
  const Eigen::VectorXd off = nominal_ - x_;
  const Eigen::Index arm = field_terms();
  std::vector<bool> is_smooth(static_cast<std::size_t>(model_.terms()), false);
  for (const SmoothTerms& terms : smooth_) {
    const Eigen::Index n = terms.kernel.rows();
    add_kernel(arm + terms.first, terms.kernel, terms.log_det, priors.*terms.sigma,
               off.segment(terms.first, n));
    std::fill_n(is_smooth.begin() + terms.first, n, true);
  }
  for (Eigen::Index i = 0; i < model_.terms(); ++i)
    if (!is_smooth[static_cast<std::size_t>(i)]) add_diagonal(arm + i, sigma_[i], off[i]);
}

bool JointEquations::solve(const JointPriors& priors) {
  if (basis_.width != priors.field_width || F_.rows() != J_.rows()) set_width(priors.field_width);
  if (!weighed_ || !same_noise(priors, weighed_by_)) weigh(priors);
  add_priors(priors);
  auto L = lower_factor(H_);
  if (!L) return false;
  L_ = std::move(*L);
  half_ = solve_lower(L_, half_);
  solution_ = solve_lower_transposed(L_, half_);
  return true;
}

std::optional<Eigen::VectorXd> JointEquations::solve_in_steps(const JointPriors& priors,
                                                              const Eigen::VectorXd& start) {
  Eigen::VectorXd x = start.size() > 0 ? start : nominal_;
  // The Gaussians' weights balance each other by much more than the function that they make.
  constexpr double kAnySize = std::numeric_limits<double>::infinity();
  Eigen::VectorXd size = sigma_;
  for (const SmoothTerms& terms : smooth_)
    size.segment(terms.first, terms.kernel.rows()).setConstant(kAnySize);
  for (int step = 0; step < kMostSteps; ++step) {
    linearize(x);
    if (!solve(priors)) return std::nullopt;
    const Eigen::VectorXd dx = solution_.tail(model_.terms());
    x += dx;
    if ((dx.array() / size.array()).abs().maxCoeff() < kSmallStep) return x;
  }
  return std::nullopt;
}

Eigen::MatrixXd JointEquations::covariance() const {
  const Eigen::MatrixXd inverse = inverse_of_lower(L_);
  return inverse.transpose() * inverse;
}

double JointEquations::log_likelihood() const {
  return -0.5 * (squares_ + told_.squares + prior_squares_ - half_.squaredNorm() + noise_log_det_ +
                 told_.log_determinant + log_det_of(L_) - prior_log_det_);
}

std::vector<double> JointEquations::chi2() const {
  // Residuals scatter by what a sample's pull leaves of its noise, I - A (A^T A)^-1 A^T.
  const Eigen::VectorXd left = z_white_ - A_ * solution_;
  const Eigen::MatrixXd pull = solve_lower(L_, A_.transpose());
  std::vector<double> all;
  for (Eigen::Index row = 0; row < A_.rows(); row += kRows) {
    const auto of_pose = pull.middleCols<kRows>(row);
    const PoseWeight covariance = PoseWeight::Identity() - of_pose.transpose() * of_pose;
    const PoseRows residual = left.segment<kRows>(row);
    all.push_back(residual.dot(solve_symmetric(covariance, residual).col(0)));
  }
  return all;
}

std::optional<JointFit> fit_jointly(const ArmModel& model, const JointPriors& priors,
                                    const std::vector<PoseSample>& samples, double field_radius,
                                    const LaidDots& board, const Eigen::VectorXd& start) {
  JointEquations equations(model, samples, field_radius, board);
  const auto x = equations.solve_in_steps(priors, start);
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

}  // namespace planar
