#include "planar_servo/arm/following_error.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "planar_servo/core/decompositions.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr Eigen::Index kPatterns = 6;  // shift, its growth in time, stretch and turn
/// A run has thousands of targets, and each asks anew.
constexpr double kFalseFollowing = 1e-6;

}  // namespace

FollowingError::FollowingError(FoundArm found)
    : found_(std::move(found)), warmth_(hourly_drift(found_).diagonal().cwiseSqrt().asDiagonal()) {}

FollowingError::Look FollowingError::look_at(const ArmLook& look, double t_s) const {
  const Eigen::Matrix2Xd J = found_.form.jacobian(look.motors, found_.x).topRows<2>();
  Eigen::Matrix2Xd rows(2, found_.factor.cols() + warmth_.cols() + 2);
  rows << J * found_.factor + look.vision_rows, J * warmth_,
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
  Eigen::Matrix2d covariance = at.rows * at.rows.transpose();
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
  const Eigen::MatrixXd L = *lower_factor(covariance), P = patterns();
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
                  mm(mean_m.y()), fitted.segment<2>(2).norm() / kMillimetre),
      "neither scatter nor warmth explains that: does the camera move, or does a drive lose steps? "
      "planar-check-cell says what has moved"};
}

}  // namespace planar
