#include "planar_servo/calibration/readings/smooth_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "planar_servo/core/decompositions.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr Eigen::Index kFixedTerms = 7;  // the last one is the trend
/// Width of the slow drift, as a share of the recording.
constexpr double kDriftWidth = 1.0 / 3.0;
constexpr double kOutlierShare = 0.02;
constexpr double kOutlierSize_m = 1.0 * kMillimetre;
constexpr ErrorTuning kLeast{-3.5, -4.0, -4.0}, kMost{1.5, 14.0, 8.0};

double log_density_of_outlier() {
  return std::log(kOutlierShare / (2.0 * kPi * kOutlierSize_m * kOutlierSize_m));
}

Eigen::MatrixXd matern(const Eigen::MatrixXd& distances, double width) {
  const Eigen::ArrayXXd r = distances.array() * (std::sqrt(5.0) / width);
  return (1.0 + r + r.square() / 3.0) * (-r).exp();
}

ErrorTuning within_bounds(const ErrorTuning& t) {
  return {std::clamp(t.width, kLeast.width, kMost.width),
          std::clamp(t.field, kLeast.field, kMost.field),
          std::clamp(t.drift, kLeast.drift, kMost.drift)};
}

/// Takes out of X what the columns of F explain.
void take_out(const Eigen::MatrixXd& F, Eigen::MatrixXd& X) {
  X -= F * solve_symmetric(F.transpose() * F, F.transpose() * X);
}

/// Returns the product of the conjugate of `a` with `b`, whose columns are real and imaginary
/// parts, summed over the rows: the step along x and y of which `a` is the shape.
Eigen::Vector2d product(const Eigen::MatrixX2d& a, const Eigen::MatrixX2d& b) {
  return {a.col(0).dot(b.col(0)) + a.col(1).dot(b.col(1)),
          a.col(0).dot(b.col(1)) - a.col(1).dot(b.col(0))};
}

}  // namespace

SmoothErrors::SmoothErrors(const std::vector<TimedError>& errors, SlowDrift drift)
    : drifts_(drift == SlowDrift::kAllowed) {
  const auto n = static_cast<Eigen::Index>(errors.size());
  Eigen::MatrixX2d p(n, 2);
  Eigen::VectorXd t(n);
  errors_.resize(n, 2);
  headings_.resize(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const TimedError& e = errors[static_cast<std::size_t>(i)];
    p.row(i) = e.p.transpose();
    errors_.row(i) = e.error.transpose();
    headings_.row(i) << std::cos(e.phi), std::sin(e.phi);
    t[i] = static_cast<double>(i) / static_cast<double>(n);
  }
  p.rowwise() -= p.colwise().mean().eval();
  p /= p.rowwise().norm().maxCoeff();
  distances_.resize(n, n);
  drift_.resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    distances_.col(j) = (p.rowwise() - p.row(j)).rowwise().norm();
    drift_.col(j) = (-0.5 * ((t.array() - t[j]) / kDriftWidth).square()).exp();
  }
  const Eigen::ArrayXd x = p.col(0).array(), y = p.col(1).array();
  fixed_.resize(n, kFixedTerms);
  fixed_ << Eigen::VectorXd::Ones(n), p, x.square(), x * y, y.square(), t;
  if (!drifts_) fixed_.conservativeResize(Eigen::NoChange, kFixedTerms - 1);
}

bool SmoothErrors::is_outlier(double distance, double deviation) {
  const double ratio = distance / deviation;
  const double log_density = -0.5 * ratio * ratio - std::log(2.0 * kPi * deviation * deviation);
  return log_density + std::log(1.0 - kOutlierShare) < log_density_of_outlier();
}

Eigen::MatrixX2d SmoothErrors::shape(const StepShape& step) const {
  const Eigen::Index late = size() - step.first;
  Eigen::MatrixX2d shape = Eigen::MatrixX2d::Zero(size(), 2);
  if (step.frame == StepFrame::kTool)
    shape.bottomRows(late) = headings_.bottomRows(late);
  else
    shape.col(0).tail(late).setOnes();
  if (step.grows) shape.array().colwise() *= Eigen::ArrayXd::LinSpaced(size(), 0.0, 1.0);
  return shape;
}

double SmoothErrors::apart_from_place(const StepShape& step) const {
  constexpr int kHighest = 4;
  Eigen::MatrixXd powers(size(), 0);
  for (int i = 0; i <= kHighest; ++i)
    for (int j = 0; i + j <= kHighest; ++j) {
      powers.conservativeResize(Eigen::NoChange, powers.cols() + 1);
      powers.rightCols<1>() = fixed_.col(1).array().pow(i) * fixed_.col(2).array().pow(j);
    }
  Eigen::MatrixXd whole = shape(step);
  whole.rowwise() -= whole.colwise().mean().eval();
  Eigen::MatrixXd apart = whole;
  take_out(powers, apart);
  return apart.squaredNorm() / whole.squaredNorm();
}

Eigen::MatrixXd SmoothErrors::factor(const ErrorTuning& tuning, const Outliers& outliers) const {
  Eigen::MatrixXd covariance = std::exp(tuning.field) * matern(distances_, std::exp(tuning.width));
  if (drifts_) covariance += std::exp(tuning.drift) * drift_;
  for (Eigen::Index i = 0; i < size(); ++i)
    covariance(i, i) += outliers[static_cast<std::size_t>(i)] ? kNoWeight : 1.0;
  return lower_factor(covariance).value();
}

SmoothFit SmoothErrors::fit(const ErrorTuning& tuning, const Outliers& outliers,
                            const std::optional<StepShape>& step) const {
  const Eigen::MatrixXd L = factor(tuning, outliers);
  Eigen::MatrixXd F = solve_lower(L, fixed_), X(size(), step ? 4 : 2);
  X.leftCols<2>() = errors_;
  if (step) X.rightCols<2>() = shape(*step);
  X = solve_lower(L, std::move(X));
  take_out(F, X);
  SmoothFit fit;
  fit.tuning = tuning;
  double squares = X.leftCols<2>().squaredNorm(), part = 1.0;
  if (step) {
    part = X.rightCols<2>().squaredNorm();
    fit.step = product(X.rightCols<2>(), X.leftCols<2>()) / part;
    squares -= part * fit.step.squaredNorm();
  }
  const double out = static_cast<double>(std::count(outliers.begin(), outliers.end(), true)),
               in = static_cast<double>(size()) - out;
  const double variance = squares / (2.0 * in);
  fit.noise = std::sqrt(variance);
  fit.step_sigma = fit.noise / std::sqrt(part);
  fit.log_likelihood = -2.0 * L.diagonal().array().log().sum() + out * std::log(kNoWeight) -
                       in * (std::log(2.0 * kPi * variance) + 1.0) +
                       in * std::log(1.0 - kOutlierShare) + out * log_density_of_outlier();
  return fit;
}

SmoothFit SmoothErrors::best_start(const ErrorTuning& guess, const Outliers& outliers,
                                   const std::optional<StepShape>& step) const {
  SmoothFit best = fit(guess, outliers, step);
  for (const double width : {-1.5, -0.5, 0.5})
    for (const double field : {0.0, 4.0, 8.0}) {
      const SmoothFit tried = fit({width, field, kLeast.drift}, outliers, step);
      if (tried.log_likelihood > best.log_likelihood) best = tried;
    }
  return best;
}

SmoothFit SmoothErrors::tuned(const ErrorTuning& guess, const Outliers& outliers,
                              const std::optional<StepShape>& step) const {
  constexpr double kFirstStride = 1.0, kLastStride = 0.2;
  constexpr std::array<double ErrorTuning::*, 3> kAxes{&ErrorTuning::width, &ErrorTuning::field,
                                                       &ErrorTuning::drift};
  SmoothFit best = best_start(guess, outliers, step);
  for (double stride = kFirstStride; stride > kLastStride;) {
    const double before = best.log_likelihood;
    for (const auto axis : kAxes)
      for (const double way : {-stride, stride}) {
        ErrorTuning tuning = best.tuning;
        tuning.*axis += way;
        const SmoothFit tried = fit(within_bounds(tuning), outliers, step);
        if (tried.log_likelihood > best.log_likelihood) best = tried;
      }
    constexpr double kWorthAnother = 0.05;
    if (best.log_likelihood < before + kWorthAnother) stride *= 0.5;
  }
  return best;
}

SmoothRemainders SmoothErrors::remainders(const ErrorTuning& tuning, const Outliers& outliers,
                                          const std::optional<StepShape>& step) const {
  const Eigen::MatrixXd L = factor(tuning, outliers);
  Eigen::MatrixXd F = solve_lower(L, fixed_), W = inverse_of_lower(L);
  take_out(F, W);
  SmoothRemainders left;
  left.precision = W.transpose() * W;
  left.diagonal = left.precision.diagonal();
  left.weighted = left.precision * errors_;
  if (!step) return left;
  const Eigen::MatrixX2d v = shape(*step), Rv = left.precision * v;
  const double part = v.cwiseProduct(Rv).sum();
  const Eigen::Vector2d size = product(v, left.weighted) / part;
  left.diagonal -= Rv.rowwise().squaredNorm().array() / part;
  left.weighted.col(0) -= Rv.col(0) * size.x() - Rv.col(1) * size.y();
  left.weighted.col(1) -= Rv.col(0) * size.y() + Rv.col(1) * size.x();
  return left;
}

}  // namespace planar
