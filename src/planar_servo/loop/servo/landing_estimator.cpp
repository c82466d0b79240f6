#include "planar_servo/loop/servo/landing_estimator.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// The share of a correction by which the persistent error may change: gear ripple of 0.02 degrees
/// and a period of 3.6 degrees changes by 3.5 % of a turn, links off by 1 % add little.
constexpr double kChangePerStep = 0.035;

Eigen::Matrix2d isotropic(double deviation) {
  return deviation * deviation * Eigen::Matrix2d::Identity();
}

/// Returns the covariance of d + v with (d, v).
Eigen::Matrix<double, 4, 2> with_sight(const Eigen::Matrix4d& covariance) {
  return covariance.leftCols<2>() + covariance.rightCols<2>();
}

Eigen::Matrix2d sight_covariance(const Eigen::Matrix4d& covariance, const LandingLook& look) {
  const Eigen::Matrix<double, 4, 2> cross = with_sight(covariance);
  return cross.topRows<2>() + cross.bottomRows<2>() + isotropic(look.scatter_m) +
         isotropic(look.noise_m);
}

/// Returns the covariance of where the stop lands with where it is seen.
Eigen::Matrix2d landing_with_sight(const Eigen::Matrix4d& covariance, const LandingLook& look) {
  return with_sight(covariance).topRows<2>() + isotropic(look.scatter_m);
}

/// Returns the mean of min(limit, |v|) for a vector v whose components deviate by `deviation_m`.
double mean_below_m(double deviation_m, double limit_m) {
  if (deviation_m == 0.0) return 0.0;
  return std::sqrt(0.5 * kPi) * deviation_m * std::erf(limit_m / (std::sqrt(2.0) * deviation_m));
}

// The factors of the model's scatter that are tried are powers of the root of 2, from 1/4 to 64.
constexpr int kLeastPower = -4, kGreatestPower = 12;
/// The model's scatter counts like so many stops seen along one axis.
constexpr double kPseudoCounts = 4.0;
/// Now and then a stop scatters ten times as far: something stuck, or somebody touched the arm.
constexpr double kOutlierShare = 0.01, kOutlierFactor = 10.0;
/// Each look keeps this share of what earlier ones said of the scatter, which changes with wear and
/// warmth: the last two hundred looks count.
constexpr double kMemory = 0.995;

/// A smaller deviation is not worth stopping for.
constexpr double kWorthADoubt_m = 50e-6;

/// Returns the log prior of a factor whose square is inverse gamma, up to a constant.
double log_credibility(double factor) {
  const double square = factor * factor;
  return -0.5 * kPseudoCounts * (std::log(square) + 1.0 / square);
}

}  // namespace

double Innovation::chi_squared() const {
  return value.dot(covariance.inverse() * value);
}

double Innovation::log_likelihood() const {
  return -0.5 * (chi_squared() + std::log(covariance.determinant())) - std::log(2.0 * kPi);
}

Eigen::Matrix4d LandingFilter::covariance_at(const Eigen::Vector2d& p_c) const {
  Eigen::Matrix4d covariance = covariance_;
  if (has_looked_)
    covariance.topLeftCorner<2, 2>() += isotropic(kChangePerStep * (p_c - p_c_).norm());
  return covariance;
}

Innovation LandingFilter::innovation(const LandingLook& look) const {
  return {look.p - look.p_c - mean_.head<2>() - mean_.tail<2>(),
          sight_covariance(covariance_at(look.p_c), look)};
}

void LandingFilter::take(const LandingLook& look) {
  const Innovation found = innovation(look);
  covariance_ = covariance_at(look.p_c);
  const Eigen::Matrix2d weight = found.covariance.inverse();
  const Eigen::Matrix2d cross = landing_with_sight(covariance_, look);
  landing_.mean = look.p_c + mean_.head<2>() + cross * weight * found.value;
  landing_.covariance = covariance_.topLeftCorner<2, 2>() + isotropic(look.scatter_m) -
                        cross * weight * cross.transpose();
  const Eigen::Matrix<double, 4, 2> gain = with_sight(covariance_) * weight;
  mean_ += gain * found.value;
  covariance_ -= gain * with_sight(covariance_).transpose();
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  p_c_ = look.p_c;
  has_looked_ = true;
}

double LandingFilter::revealed_m(const LandingLook& next) const {
  const Eigen::Matrix4d covariance = covariance_at(next.p_c);
  const Eigen::Matrix2d cross = landing_with_sight(covariance, next);
  const Eigen::Matrix2d revealed =
      cross * sight_covariance(covariance, next).inverse() * cross.transpose();
  return per_axis(revealed);
}

Spread LandingFilter::spread(const LandingLook& next) const {
  LandingFilter later = *this;
  later.take(next);
  return {revealed_m(next), later.revealed_m(next)};
}

double nearest_expected_m(const Spread& spread, int corrections) {
  double nearest_m = std::numeric_limits<double>::infinity();  // the last place must do
  for (int left = 1; left <= corrections; ++left)
    nearest_m = mean_below_m(left < corrections ? spread.later_m : spread.next_m, nearest_m);
  return nearest_m;
}

LandingEstimator::LandingEstimator(LandingModel& model, double play_m)
    : model_(model), play_m_(play_m) {
  for (int i = kLeastPower; i <= kGreatestPower; ++i)
    for (int j = kLeastPower; j <= kGreatestPower; ++j)
      members_.push_back({std::exp2(0.5 * i), std::exp2(0.5 * j)});
  share_weights();
}

void LandingEstimator::share_weights() {
  const auto log_weight = [](const Member& member) {
    return log_credibility(member.factor) + log_credibility(member.short_factor) +
           member.log_likelihood;
  };
  double greatest = log_weight(members_.front()), sum = 0.0;
  for (const Member& member : members_) greatest = std::max(greatest, log_weight(member));
  for (Member& member : members_) sum += member.weight = std::exp(log_weight(member) - greatest);
  for (Member& member : members_) member.weight /= sum;
}

double LandingEstimator::scatter_m(const Member& member, bool is_short) const {
  const double after_long_m = member.factor * prior_->scatter_m;
  return is_short ? std::min(after_long_m, member.short_factor * prior_->short_scatter_m)
                  : after_long_m;
}

double LandingEstimator::long_scatter_m() const {
  double mean_m = 0.0;
  for (const Member& member : members_) mean_m += member.weight * scatter_m(member, false);
  return mean_m;
}

void LandingEstimator::start(const ServoStep& step) {
  prior_ = model_.at(step.theta_c, step.measurement);
  if (!(prior_->scatter_m > 0.0 && prior_->short_scatter_m > 0.0))
    throw std::invalid_argument("a landing's scatter must be positive");
  for (Member& member : members_) member.filter = LandingFilter(prior_->covariance);
  was_unexpected_ = has_strayed_ = false;
}

void LandingEstimator::allow_for_stray(const LandingLook& look) {
  if (prior_->stray_m == 0.0) return;
  Eigen::Matrix4d strayed = prior_->covariance;
  strayed.topRightCorner<2, 2>().setZero();
  strayed.bottomLeftCorner<2, 2>().setZero();
  strayed.diagonal().head<2>().array() += prior_->stray_m * prior_->stray_m;
  const double likelihood = std::exp(LandingFilter(strayed).innovation(look).log_likelihood());
  double expected = 0.0;
  for (const Member& member : members_) {
    LandingLook supposed = look;
    supposed.scatter_m = scatter_m(member, false);
    expected += member.weight * std::exp(member.filter.innovation(supposed).log_likelihood());
  }
  if (kOutlierShare * likelihood < (1.0 - kOutlierShare) * expected) return;
  has_strayed_ = true;
  prior_->covariance = strayed;
  for (Member& member : members_) member.filter = LandingFilter(strayed);
}

LandingEstimate LandingEstimator::take(const ServoStep& step, const Eigen::Vector2d& p_c) {
  if (looks_ == 0) start(step);
  const bool is_short = looks_ > 0 && (p_c - p_c_).norm() < kShortMove_m;
  const LandingLook look{p_c, step.measurement.tip.p, step.measurement.noise_m, 0.0};
  if (looks_ == 0) allow_for_stray(look);
  const bool is_unexpected = is_beyond_play(look) && chance_of(look, is_short) < kNoChance;
  weigh(look, is_short);
  LandingEstimate estimate = mixture(step.target.p, look);
  estimate.seems_strayed =
      looks_ == 0 && has_strayed_ && (look.p - look.p_c).norm() > kWorthADoubt_m;
  estimate.is_contradicted = is_unexpected && was_unexpected_;
  was_unexpected_ = is_unexpected;
  model_.learn({step.theta_c, step.measurement, looks_ == 0, has_strayed_,
                estimate.seems_strayed && arrivals_ > 0, long_scatter_m()});
  p_c_ = p_c;
  ++looks_;
  return estimate;
}

void LandingEstimator::begin_again() {
  looks_ = 0;
  ++arrivals_;
}

bool LandingEstimator::is_beyond_play(const LandingLook& look) const {
  const auto likeliest =
      std::max_element(members_.begin(), members_.end(),
                       [](const Member& a, const Member& b) { return a.weight < b.weight; });
  return likeliest->filter.innovation(look).value.norm() > play_m_;
}

double LandingEstimator::chance_of(const LandingLook& look, bool is_short) const {
  double chance = 0.0;
  for (const Member& member : members_) {
    LandingLook supposed = look;
    supposed.scatter_m = scatter_m(member, is_short);
    // The length of an innovation in two dimensions exceeds chi with this chance.
    chance += member.weight * std::exp(-0.5 * member.filter.innovation(supposed).chi_squared());
  }
  return chance;
}

void LandingEstimator::weigh(LandingLook look, bool is_short) {
  const bool is_far = is_beyond_play(look);
  for (Member& member : members_) {
    look.scatter_m = scatter_m(member, is_short);
    LandingLook outlier = look;
    outlier.scatter_m *= kOutlierFactor;
    const double usual =
        std::log(1.0 - kOutlierShare) + member.filter.innovation(look).log_likelihood();
    const double unusual =
        std::log(kOutlierShare) + member.filter.innovation(outlier).log_likelihood();
    // An unusual first look may show the arm's persistent error; play lasts, too.
    const bool has_slipped = looks_ > 0 && is_far && unusual > usual;
    member.filter.take(has_slipped ? outlier : look);
    member.log_likelihood = kMemory * member.log_likelihood + std::max(usual, unusual) +
                            std::log1p(std::exp(-std::abs(usual - unusual)));
  }
  share_weights();
}

LandingEstimate LandingEstimator::mixture(const Eigen::Vector2d& p_d,
                                          const LandingLook& look) const {
  LandingEstimate all;
  Eigen::Vector2d next = Eigen::Vector2d::Zero();
  for (const Member& member : members_) {
    all.p += member.weight * member.filter.landing().mean;
    next += member.weight * member.filter.next_command(p_d);
  }
  all.correction = next - look.p_c;
  const bool is_short = all.correction.norm() < kShortMove_m;
  double variance = 0.0;
  for (const Member& member : members_) {
    const PlaneEstimate& landing = member.filter.landing();
    variance +=
        0.5 * member.weight * (landing.covariance.trace() + (landing.mean - all.p).squaredNorm());
    const double next_scatter_m = scatter_m(member, is_short);
    all.scatter_m += member.weight * next_scatter_m;
    const Spread spread = member.filter.spread({next, {}, look.noise_m, next_scatter_m});
    all.spread.next_m += member.weight * spread.next_m;
    all.spread.later_m += member.weight * spread.later_m;
  }
  all.deviation_m = std::sqrt(variance);
  return all;
}

double LandingEstimator::longest_jump_m() const {
  if (!prior_) return 0.0;
  const auto chance_beyond = [&](double jump_m) {
    double chance = 0.0;
    for (const Member& member : members_) {
      const double two_stops_m2 = 2.0 * std::pow(scatter_m(member, false), 2);
      chance += member.weight * std::exp(-0.5 * jump_m * jump_m / two_stops_m2);
    }
    return chance;
  };
  double within_m = 0.0, beyond_m = prior_->scatter_m;
  while (chance_beyond(beyond_m) > kNoChance) beyond_m *= 2.0;
  constexpr int kHalvings = 20;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle_m = 0.5 * (within_m + beyond_m);
    (chance_beyond(middle_m) > kNoChance ? within_m : beyond_m) = middle_m;
  }
  return beyond_m;
}

}  // namespace planar
