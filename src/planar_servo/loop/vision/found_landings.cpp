#include "planar_servo/loop/vision/found_landings.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr Eigen::Index kPatterns = 6;  // shift, its growth in time, stretch and turn
/// A run has thousands of targets, and each asks anew.
constexpr double kFalseFollowing = 1e-6;

/// One look in a million differs by this many deviations, estimated from a few looks.
constexpr double kDeviations = 6.0;
/// Looks scatter at least by the noise of the best lamps: a micrometre, at lamps 40 mm apart.
constexpr double kLeast_m = 1e-6, kLeastTurn = 25e-6;

bool is_like(double value, const std::deque<double>& others, double least) {
  const double middle = median({others.begin(), others.end()});
  return std::abs(value - middle) <
         kDeviations * std::max(least, robust_sigma({others.begin(), others.end()}));
}

/// Below this an arm repeats better than anybody has measured.
constexpr double kLeastScatter_m = 0.1e-6;

}  // namespace

FollowingError::FollowingError(FoundArm found)
    : found_(std::move(found)), warmth_(hourly_drift(found_).diagonal().cwiseSqrt().asDiagonal()) {}

FollowingError::Look FollowingError::look_at(const ArmLook& look, double t_s) const {
  const Eigen::Matrix2Xd J = found_.form.jacobian(look.motors, found_.x).topRows<2>();
  Eigen::Matrix2Xd rows(2, found_.factor.cols() + warmth_.cols() + 2);
  rows << J.lazyProduct(found_.factor) + look.vision_rows, J.lazyProduct(warmth_),
      found_.wander_m * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d p = found_.tip(look.motors).p;
  return {t_s, p, look.p - p, std::move(rows), look.sigma_m};
}

void FollowingError::take(const ArmLook& look, double t_s) {
  looks_.push_back(look_at(look, t_s));
  if (looks_.size() > kWindow) looks_.pop_front();
}

bool FollowingError::explains(const ArmLook& look) const {
  const Look at = look_at(look, 0.0);
  Eigen::Matrix2d covariance = at.rows.lazyProduct(at.rows.transpose());
  covariance.diagonal().array() += at.sigma_m * at.sigma_m;
  return std::exp(-0.5 * at.off.dot(covariance.inverse() * at.off)) > kFalseAlarm;
}

/// Returns where a unit of each pattern would have the looks; time counts back from the last one.
Eigen::MatrixXd FollowingError::patterns() const {
  const double last_s = looks_.back().t_s, span_s = std::max(1.0, last_s - looks_.front().t_s);
  Eigen::MatrixXd P(2 * looks_.size(), kPatterns);
  for (std::size_t i = 0; i < looks_.size(); ++i) {
    const auto& [t_s, p, off, rows, sigma_m] = looks_[i];
    const double since = (t_s - last_s) / span_s;
    P.middleRows<2>(static_cast<Eigen::Index>(2 * i)) << 1.0, 0.0, since, 0.0, p.x(), -p.y(), 0.0,
        1.0, 0.0, since, p.y(), p.x();
  }
  return P;
}

std::optional<Refusal> FollowingError::doubt() const {
  if (looks_.size() < kFewest) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(2 * looks_.size());
  Eigen::MatrixXd shared(n, looks_.front().rows.cols());
  Eigen::VectorXd off(n), variance(n);
  for (std::size_t i = 0; i < looks_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(2 * i);
    shared.middleRows<2>(row) = looks_[i].rows;
    off.segment<2>(row) = looks_[i].off;
    variance.segment<2>(row).setConstant(looks_[i].sigma_m * looks_[i].sigma_m);
  }
  Eigen::MatrixXd covariance = shared * shared.transpose();
  covariance.diagonal() += variance;
  const Eigen::MatrixXd L = lower_factor(covariance).value(), P = patterns();
  const Eigen::MatrixXd white_patterns = solve_lower(L, P);
  const Eigen::VectorXd off_white = solve_lower(L, off);
  const Eigen::VectorXd fitted = solve_least_squares(white_patterns, off_white);
  const double chi2 = off_white.squaredNorm() - (off_white - white_patterns * fitted).squaredNorm();
  const Eigen::Matrix2Xd moved = (P * fitted).reshaped(2, n / 2);
  const double rms_m = std::sqrt(moved.colwise().squaredNorm().mean());
  if (rms_m < kTolerated_m || chi_square_tail(chi2, kPatterns) > kFalseFollowing)
    return std::nullopt;
  const Eigen::Vector2d mean_m = moved.rowwise().mean();
  return Refusal{
      fmt::format("in the last {:.0f} s, {} targets were first seen {:.3f} mm (rms) from where the "
                  "arm, as it was found, lands, by ({:.3f}, {:.3f}) mm on average, of which "
                  "{:.3f} mm came meanwhile",
                  looks_.back().t_s - looks_.front().t_s, looks_.size(), mm(rms_m), mm(mean_m.x()),
                  mm(mean_m.y()), mm(fitted.segment<2>(2).norm())),
      "neither scatter nor warmth explains that: does the camera move, or does a drive lose steps? "
      "planar-check-cell says what has moved",
      "", Cause::kContradiction};
}

void LampAgreement::take(double separation_m, double turn) {
  separations_m_.push_back(separation_m);
  turns_.push_back(turn);
  if (turns_.size() <= kWindow) return;
  separations_m_.pop_front();
  turns_.pop_front();
}

bool LampAgreement::agrees(double separation_m, double turn) const {
  return knows() && is_like(separation_m, separations_m_, kLeast_m) &&
         is_like(turn, turns_, kLeastTurn);
}

FoundLandings::FoundLandings(LampField field, FoundArm arm, const Transmission& transmission,
                             double stray_m)
    : field_(std::move(field)),
      found_(std::move(arm)),
      transmission_(transmission),
      stray_m_(stray_m),
      following_(found_) {
  if (field_.factor.cols() != found_.factor.cols())
    throw std::invalid_argument("a field and an arm were not found together");
}

Eigen::Matrix2Xd FoundLandings::vision_rows(const TipMeasurement& look) const {
  // Vision subtracts the found field, so it errs by minus the field's rows at the end point.
  return -end_point_rows(field_, look.lamps_B).lazyProduct(field_.factor);
}

ArmLook FoundLandings::arm_look(const SeenLanding& seen) const {
  return {motors(seen.theta_c), seen.look.tip.p, vision_rows(seen.look),
          std::hypot(seen.scatter_m, seen.look.noise_m, found_.wander_m)};
}

LandingPrior FoundLandings::prior_of(const Eigen::Matrix4d& covariance, double scatter_m) const {
  LandingPrior prior;
  prior.covariance = covariance;
  prior.covariance.diagonal().head<2>().array() += found_.wander_m * found_.wander_m;
  prior.scatter_m = prior.short_scatter_m = std::max(scatter_m, kLeastScatter_m);
  prior.stray_m = stray_m_;
  return prior;
}

LandingPrior FoundLandings::at(const Joints& theta_c, const TipMeasurement& look) const {
  // True values differ from the found ones by the factor times numbers of unit variance; the arm
  // misses its command by its rows of that.
  const Eigen::Matrix2Xd J = found_.form.jacobian(motors(theta_c), found_.x).topRows<2>();
  Eigen::Matrix4Xd rows(4, found_.factor.cols());
  rows << J.lazyProduct(found_.factor), vision_rows(look);
  return prior_of(rows.lazyProduct(rows.transpose()), found_.scatter_m);
}

void FoundLandings::learn(const SeenLanding& seen) {
  of_view_.reset();
  const auto lamps_B = compensate(field_, seen.look.lamps_B).lamps_B;
  const double separation_m = (lamps_B[1] - lamps_B[0]).norm();
  const TipPose landed = found_.tip(motors(seen.theta_c));
  const double turn = wrap_angle(seen.look.tip.phi - landed.phi);
  if (seen.is_first && !seen.has_strayed) {
    following_.take(arm_look(seen), seen.look.t_s);
    lamps_.take(separation_m, turn);
  }
  if (!seen.stays_off) return;
  const bool agrees = lamps_.agrees(separation_m, turn);
  of_view_ = {
      {fmt::format(
           "the tool is seen {:.3f} mm from where the arm should land, again after the arm "
           "went away and came back, and {}: is something on the camera's window or in its "
           "view (a drop, a reflection), or does the arm stray? planar-check-cell says what "
           "has moved",
           mm((seen.look.tip.p - landed.p).norm()),
           agrees           ? "the lamps stand to each other as at other targets"
           : lamps_.knows() ? "the lamps do not stand to each other as at other targets"
                            : "too few other targets were seen to compare the lamps with"),
       "", "", Cause::kContradiction},
      lamps_.knows() && !agrees};
}

std::optional<Doubt> FoundLandings::doubt() const {
  if (of_view_) return of_view_;
  if (auto moved = following_.doubt()) return Doubt{std::move(*moved), true};
  return std::nullopt;
}

LearningLandings::LearningLandings(LampField field, const FoundArm& found, LearnedArm known,
                                   const Transmission& transmission, double stray_m)
    : FoundLandings(std::move(field), found, transmission, stray_m),
      learner_(found, std::move(known)) {}

LandingPrior LearningLandings::at(const Joints& theta_c, const TipMeasurement& look) const {
  return prior_of(learner_.landing_covariance(motors(theta_c), vision_rows(look), look.t_s),
                  learner_.learned().arm.scatter_m);
}

void LearningLandings::learn(const SeenLanding& seen) {
  FoundLandings::learn(seen);
  // Later looks share errors that no term describes, so they are not independent of the first.
  if (!seen.is_first) return;
  if (seen.has_strayed) return unlearn(seen);
  if (learner_.take(arm_look(seen), seen.look.t_s) != Lesson::kBeyondCaps || has_warned_) return;
  has_warned_ = true;
  spdlog::warn(
      "the looks suggest an arm that has changed more than warmth or wear explains; so large a "
      "change is not learned; planar-check-cell says whether the cell needs a new calibration");
}

void LearningLandings::unlearn(const SeenLanding& seen) {
  if (learner_.lessons() == 0 || !explains(seen)) return;
  if (!std::exchange(has_discarded_, true))
    spdlog::warn(
        "the arm lands as the calibration found it, not as it was learned since; what was learned "
        "is discarded, now and whenever that happens again");
  learner_ = ArmLearner(found(), unlearned(found(), learner_.learned().arm.form.posture));
}

}  // namespace planar
