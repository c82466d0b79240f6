#include "planar_servo/calibration/readings/change_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// From place `first` on, all errors differ by a constant in this frame, or by an amount that grows
/// from zero to it over all places.
struct StepShape {
  Eigen::Index first{0};
  StepFrame frame{StepFrame::kBase};
  bool grows{false};
};

/// The field's width and the variances of field and drift, as natural logarithms.
struct ErrorTuning {
  double width{0.0};  ///< of the field, in units of the places' extent
  double field{0.0};  ///< variance, in units of the noise's
  double drift{0.0};  ///< variance, in units of the noise's
};

/// Errors as explained with one tuning.
struct SmoothFit {
  ErrorTuning tuning;
  double log_likelihood{0.0};
  double noise{0.0};  ///< per axis, metres
  Eigen::Vector2d step{0.0, 0.0};
  double step_sigma{0.0};  ///< per axis, metres
};

/// What the smooth terms leave of the errors, and the inverse of the errors' covariance, in units
/// of the noise's variance, without the fixed terms.
struct SmoothRemainders {
  Eigen::MatrixX2d weighted;  ///< precision * errors; the remainders where noise has unit weight
  Eigen::ArrayXd diagonal;    ///< of the precision
  Eigen::MatrixXd precision;  ///< without a step
};

/// Whether errors may drift, by a linear trend and a slow Gaussian process over time.
enum class SlowDrift { kAllowed, kNone };

using Outliers = std::vector<bool>;
/// An outlier's variance, in units of the noise's: it does not affect the others.
constexpr double kNoWeight = 1e6;

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

/// Returns whether an error that the others predict with this deviation is more likely an
/// outlier.
bool is_outlier(double distance, double deviation) {
  const double ratio = distance / deviation;
  const double log_density = -0.5 * ratio * ratio - std::log(2.0 * kPi * deviation * deviation);
  return log_density + std::log(1.0 - kOutlierShare) < log_density_of_outlier();
}

/// Explains errors by a Gaussian process over the places (Matern 5/2), a quadratic of the place, a
/// slow drift where that is allowed, noise and, if asked, a step. Outliers have a wide density of
/// their own and do not affect the others.
class SmoothErrors {
 public:
  explicit SmoothErrors(const std::vector<TimedError>& errors,
                        SlowDrift drift = SlowDrift::kAllowed)
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

  Eigen::Index size() const { return errors_.rows(); }
  const Eigen::MatrixX2d& errors() const { return errors_; }
  void set_errors(Eigen::MatrixX2d errors) { errors_ = std::move(errors); }

  /// Returns the tuning of the largest likelihood. The search begins at the best of a coarse grid
  /// and of `guess`.
  SmoothFit tuned(const ErrorTuning& guess, const Outliers& outliers,
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
      if (!(best.log_likelihood - before >= kWorthAnother)) stride *= 0.5;
    }
    return best;
  }

  SmoothRemainders remainders(const ErrorTuning& tuning, const Outliers& outliers,
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

  /// Returns what a step of one metre along x of its frame adds to each error.
  Eigen::MatrixX2d shape(const StepShape& step) const {
    const Eigen::Index late = size() - step.first;
    Eigen::MatrixX2d shape = Eigen::MatrixX2d::Zero(size(), 2);
    if (step.frame == StepFrame::kTool)
      shape.bottomRows(late) = headings_.bottomRows(late);
    else
      shape.col(0).tail(late).setOnes();
    if (step.grows) shape.array().colwise() *= Eigen::ArrayXd::LinSpaced(size(), 0.0, 1.0);
    return shape;
  }

  /// Returns the share of a shape's variance over the places that no smooth function of the place,
  /// a polynomial of the fourth degree, gives: small where time tells the place.
  double apart_from_place(const StepShape& step) const {
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

 private:
  SmoothFit fit(const ErrorTuning& tuning, const Outliers& outliers,
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

  SmoothFit best_start(const ErrorTuning& guess, const Outliers& outliers,
                       const std::optional<StepShape>& step) const {
    SmoothFit best = fit(guess, outliers, step);
    for (const double width : {-1.5, -0.5, 0.5})
      for (const double field : {0.0, 4.0, 8.0}) {
        const SmoothFit tried = fit({width, field, kLeast.drift}, outliers, step);
        if (tried.log_likelihood > best.log_likelihood) best = tried;
      }
    return best;
  }

  Eigen::MatrixXd factor(const ErrorTuning& tuning, const Outliers& outliers) const {
    Eigen::MatrixXd covariance =
        std::exp(tuning.field) * matern(distances_, std::exp(tuning.width));
    if (drifts_) covariance += std::exp(tuning.drift) * drift_;
    for (Eigen::Index i = 0; i < size(); ++i)
      covariance(i, i) += outliers[static_cast<std::size_t>(i)] ? kNoWeight : 1.0;
    return lower_factor(covariance).value();
  }

  Eigen::MatrixX2d errors_;
  Eigen::MatrixX2d headings_;  ///< cosine and sine of phi
  Eigen::MatrixXd distances_;  ///< between places, in units of their extent
  Eigen::MatrixXd drift_;      ///< covariance in time of a drift of unit variance
  Eigen::MatrixXd fixed_;      ///< quadratic of the place, and trend where it may drift
  bool drifts_;
};

/// With less of a trend's shape apart from the place, a field that is not quite as it is modelled
/// passes for a trend.
constexpr double kLeastApart = 0.3;

/// The most likely explanation of the errors with or without some step, and the outliers that go
/// with it.
struct Explanation {
  SmoothFit fit;
  Outliers outliers;
  std::optional<StepShape> step{};
};

/// Returns how far an error lies from what the others predict.
Eigen::RowVector2d miss_of(const SmoothRemainders& left, Eigen::Index i) {
  return left.weighted.row(i) / left.diagonal[i];
}

/// Returns the deviation of miss_of() per axis if the error is no outlier.
double deviation_of_miss(const Explanation& by, const SmoothRemainders& left, Eigen::Index i) {
  const bool is_out = by.outliers[static_cast<std::size_t>(i)];
  const double variance = 1.0 / left.diagonal[i] - (is_out ? kNoWeight - 1.0 : 0.0);
  return by.fit.noise * std::sqrt(std::max(1.0, variance));
}

/// Returns which errors are outliers, as the others predict them.
Outliers outliers_beside(const SmoothErrors& errors, const Explanation& by,
                         const SmoothRemainders& left) {
  constexpr long kLargestShare = 5;
  Outliers outliers = by.outliers;
  for (Eigen::Index i = 0; i < errors.size(); ++i)
    outliers[static_cast<std::size_t>(i)] =
        is_outlier(miss_of(left, i).norm(), deviation_of_miss(by, left, i));
  const bool few = kLargestShare * std::count(outliers.begin(), outliers.end(), true) <=
                   static_cast<long>(errors.size());
  return few ? outliers : by.outliers;
}

/// Alternates between naming outliers and tuning until both agree.
void leave_out_outliers(const SmoothErrors& errors, Explanation& found) {
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds; ++round) {
    const SmoothRemainders left = errors.remainders(found.fit.tuning, found.outliers, found.step);
    Outliers outliers = outliers_beside(errors, found, left);
    if (outliers == found.outliers) return;
    found.outliers = std::move(outliers);
    found.fit = errors.tuned(found.fit.tuning, found.outliers, found.step);
  }
}

Outliers no_outliers(const SmoothErrors& errors) {
  return Outliers(static_cast<std::size_t>(errors.size()), false);
}

Explanation without_step(const SmoothErrors& errors) {
  Explanation found;
  found.outliers = no_outliers(errors);
  found.fit = errors.tuned({}, found.outliers, {});
  leave_out_outliers(errors, found);
  return found;
}

/// Returns the explanation with this step. It starts from the tuning of another, but without its
/// outliers, because a step after which few places come explains what otherwise are outliers.
Explanation with_step(const SmoothErrors& errors, const StepShape& step, const Explanation& start) {
  Explanation found{start.fit, no_outliers(errors), step};
  found.outliers =
      outliers_beside(errors, found, errors.remainders(found.fit.tuning, found.outliers, step));
  found.fit = errors.tuned(found.fit.tuning, found.outliers, step);
  leave_out_outliers(errors, found);
  return found;
}

/// Returns the errors with outliers moved to where they are no longer outliers: a few neighbouring
/// ones may be a step.
Eigen::MatrixX2d with_outliers_moved(const SmoothErrors& errors, const Explanation& by) {
  constexpr double kMostDeviations = 5.0;
  const SmoothRemainders left = errors.remainders(by.fit.tuning, by.outliers, by.step);
  Eigen::MatrixX2d moved = errors.errors();
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    if (!by.outliers[static_cast<std::size_t>(i)]) continue;
    const Eigen::RowVector2d miss = miss_of(left, i);
    const double most = kMostDeviations * deviation_of_miss(by, left, i);
    moved.row(i) -= std::max(0.0, 1.0 - most / miss.norm()) * miss;
  }
  return moved;
}

constexpr std::size_t kFewestPlaces = 32, kMostPlaces = 500;
constexpr Eigen::Index kFewestOnASide = 5;
/// Terms that every explanation has: a quadratic of the place, a trend and the step itself.
constexpr double kTerms = 8.0;
/// Below it, which is about half a degree between the tool's directions, frames cannot be told
/// apart.
constexpr double kLeastTurn = 1e-4;

/// A step, and by how much it reduces the squares of the weighted errors.
struct Gain {
  StepShape step;
  double squares{-1.0};
};

/// Returns the step in this frame that reduces the squares most.
Gain largest_gain(const SmoothErrors& errors, const SmoothRemainders& left, StepFrame frame) {
  const Eigen::Index n = errors.size();
  const Eigen::MatrixX2d u = errors.shape({0, frame});
  Eigen::Vector2d sum(0.0, 0.0);
  double part = 0.0;
  Gain best;
  for (Eigen::Index k = n - 1; k >= kFewestOnASide; --k) {
    const Eigen::Index after = n - 1 - k;
    const Eigen::VectorXd beside = left.precision.col(k).tail(after);
    part += left.precision(k, k) + 2.0 * beside.dot(u.bottomRows(after) * u.row(k).transpose());
    sum += Eigen::Vector2d(u.row(k).dot(left.weighted.row(k)),
                           u(k, 0) * left.weighted(k, 1) - u(k, 1) * left.weighted(k, 0));
    constexpr double kLeastPart = 1e-6;
    if (n - k < kFewestOnASide || part < kLeastPart) continue;
    if (sum.squaredNorm() / part > best.squares) best = {{k, frame}, sum.squaredNorm() / part};
  }
  return best;
}

/// Returns the step that reduces most what this tuning leaves.
StepShape likeliest_step(SmoothErrors errors, const std::vector<StepFrame>& frames,
                         const Explanation& by) {
  errors.set_errors(with_outliers_moved(errors, by));
  const SmoothRemainders left = errors.remainders(by.fit.tuning, no_outliers(errors), {});
  Gain best;
  for (const StepFrame frame : frames) {
    const Gain gain = largest_gain(errors, left, frame);
    if (gain.squares > best.squares) best = gain;
  }
  return best.step;
}

/// Returns the most likely explanation with a step: where it stands depends on the tuning, and the
/// tuning on the step.
Explanation with_best_step(const SmoothErrors& errors, const std::vector<StepFrame>& frames,
                           const Explanation& without) {
  constexpr int kRounds = 3;
  StepShape step = likeliest_step(errors, frames, without);
  Explanation best = with_step(errors, step, without);
  for (int round = 1; round < kRounds; ++round) {
    const StepShape next = likeliest_step(errors, frames, best);
    if (next.first == step.first && next.frame == step.frame) break;
    step = next;
    Explanation found = with_step(errors, step, best);
    if (found.fit.log_likelihood > best.fit.log_likelihood) best = std::move(found);
  }
  return best;
}

/// Returns the frames in which a step may be constant, as far as they can be told apart.
std::vector<StepFrame> frames_of(const std::vector<TimedError>& errors) {
  Eigen::Vector2d mean(0.0, 0.0);
  for (const TimedError& e : errors)
    mean += Eigen::Vector2d(std::cos(e.phi), std::sin(e.phi)) / static_cast<double>(errors.size());
  if (1.0 - mean.norm() < kLeastTurn) return {StepFrame::kBase};
  return {StepFrame::kBase, StepFrame::kTool};
}

/// Returns whether a step explains the errors better than chance could, wherever it is.
bool is_step(const Explanation& with, const Explanation& without, std::size_t candidates) {
  const auto n = static_cast<double>(with.outliers.size());
  const double gain = with.fit.log_likelihood - without.fit.log_likelihood;
  return gain * (n - kTerms) / n > std::log(static_cast<double>(candidates) / kFalseAlarm);
}

/// Returns what the fit leaves of the errors, in the step's frame, the step included.
std::vector<Eigen::Vector2d> remainders_with_step(const SmoothErrors& errors,
                                                  const Explanation& found) {
  const SmoothRemainders left = errors.remainders(found.fit.tuning, found.outliers, found.step);
  const Eigen::MatrixX2d u = errors.shape({0, found.step->frame});
  std::vector<Eigen::Vector2d> remainders;
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    const bool is_out = found.outliers[static_cast<std::size_t>(i)];
    const Eigen::RowVector2d r = (is_out ? kNoWeight : 1.0) * left.weighted.row(i);
    remainders.emplace_back(u.row(i).dot(r), u(i, 0) * r.y() - u(i, 1) * r.x());
    if (i >= found.step->first) remainders.back() += found.fit.step;
  }
  return remainders;
}

/// Returns which of `count` places are examined: all, or few enough to be quick.
std::vector<std::size_t> places_asked(std::size_t count) {
  const std::size_t stride = (count + kMostPlaces - 1) / kMostPlaces;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < count; i += stride) places.push_back(i);
  return places;
}

std::vector<TimedError> those_at(const std::vector<std::size_t>& places,
                                 const std::vector<TimedError>& errors) {
  std::vector<TimedError> asked;
  asked.reserve(places.size());
  for (const std::size_t place : places) asked.push_back(errors[place]);
  return asked;
}

}  // namespace

double ChangePoint::cost(std::size_t count) const {
  const std::size_t larger = std::max(first, count - first);
  return step.norm() * static_cast<double>(larger) / static_cast<double>(count);
}

std::optional<ChangePoint> find_change(const std::vector<TimedError>& errors) {
  if (errors.size() < kFewestPlaces) return std::nullopt;
  ChangePoint change;
  change.places = places_asked(errors.size());
  const std::vector<TimedError> asked = those_at(change.places, errors);
  const std::vector<StepFrame> frames = frames_of(asked);
  const SmoothErrors smooth(asked);
  const Explanation without = without_step(smooth);
  const Explanation with = with_best_step(smooth, frames, without);
  if (!is_step(with, without, frames.size() * asked.size())) return std::nullopt;
  change.first = change.places[static_cast<std::size_t>(with.step->first)];
  change.step = with.fit.step;
  change.sigma = with.fit.step_sigma;
  if (frames.size() > 1) change.frame = with.step->frame;
  change.left = remainders_with_step(smooth, with);
  return change;
}

std::optional<double> noise_of(const std::vector<TimedError>& errors) {
  if (errors.size() < kFewestPlaces) return std::nullopt;
  return without_step(SmoothErrors(those_at(places_asked(errors.size()), errors))).fit.noise;
}

std::optional<ErrorTrend> find_trend(const std::vector<TimedError>& errors) {
  if (errors.size() < kFewestPlaces) return std::nullopt;
  const std::vector<TimedError> asked = those_at(places_asked(errors.size()), errors);
  const std::vector<StepFrame> frames = frames_of(asked);
  const SmoothErrors smooth(asked, SlowDrift::kNone);
  const Explanation without = without_step(smooth);
  Explanation best = without;
  for (const StepFrame frame : frames) {
    const StepShape shape{0, frame, true};
    if (smooth.apart_from_place(shape) < kLeastApart) continue;
    if (Explanation with = with_step(smooth, shape, without);
        with.fit.log_likelihood > best.fit.log_likelihood)
      best = std::move(with);
  }
  if (!best.step || !is_step(best, without, frames.size())) return std::nullopt;
  ErrorTrend trend{best.fit.step, best.fit.step_sigma};
  if (frames.size() > 1) trend.frame = best.step->frame;
  return trend;
}

}  // namespace planar
