#include "planar_servo/loop/health/health_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Returns the standard deviations of a sound cell's numbers: zeros set by eye, gears and links as
/// they are made, tool and workplane as calibrated.
Numbers usual_deviations() {
  Numbers sigma;
  sigma.segment<3>(kZeroOff).setConstant(0.15 * kDegree);
  sigma.segment<3>(kGearOff).setConstant(5e-4);
  sigma.segment<2>(kLinkOff).setConstant(0.7 * kMillimetre);
  sigma.segment<4>(kLampOff).setConstant(0.02 * kMillimetre);
  sigma.segment<2>(kShiftOff).setConstant(0.1 * kMillimetre);
  sigma[kTurnOff] = 0.02 * kDegree;
  sigma[kGrowthOff] = 2e-4;
  sigma.segment<2>(kTiltOff).setConstant(2e-4);
  return sigma;
}

constexpr double kFree = 1e3;  ///< the deviation of a freed number: radians, metres or a ratio
constexpr int kMaxSteps = 25;
constexpr int kPerSight = 5;  ///< residuals: the middle, the direction, the distance
/// Error of the lamps' distance by a lens that no map corrects and a plane at another height.
constexpr double kLengthSigma = 0.01;
constexpr double kClearlyBetter = 0.1;
/// Twice the logarithm of the odds of 3,000 to 1.
constexpr double kLeastGain = 16.0;

/// Returns the residuals of the sights and then how far each number is off, in standard deviations.
Eigen::VectorXd arm_residuals(const CellModel& model, const std::vector<ArmSight>& sights,
                              const Numbers& off, const Numbers& sigma) {
  const auto n = static_cast<Eigen::Index>(sights.size());
  Eigen::VectorXd r(kPerSight * n + kNumbers);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ArmSight& sight = sights[static_cast<std::size_t>(i)];
    const LampPlaces expected = lamps_seen(model, sight.motors, off);
    const Eigen::Vector2d half = 0.5 * (expected[1] - expected[0]);
    const Eigen::Vector2d apart = 0.5 * (sight.seen_B[1] - sight.seen_B[0]);
    Eigen::Vector2d seen_half = half.norm() * apart.normalized();
    if (seen_half.dot(half) < 0.0) seen_half = -seen_half;
    r.segment<2>(kPerSight * i) = 0.5 *
                                  (sight.seen_B[0] + sight.seen_B[1] - expected[0] - expected[1]) /
                                  sight.middle_sigma_m;
    r.segment<2>(kPerSight * i + 2) = (seen_half - half) / sight.half_sigma_m;
    r[kPerSight * i + 4] = (apart.norm() / half.norm() - 1.0) / kLengthSigma;
  }
  r.tail<kNumbers>() = off.cwiseQuotient(sigma);
  return r;
}

struct ArmFit {
  double chi2{std::numeric_limits<double>::infinity()};
  Numbers off{Numbers::Zero()};
};

/// Minimises the squared residuals from `start` by Gauss-Newton with halved steps.
ArmFit fit_numbers(const CellModel& model, const std::vector<ArmSight>& sights,
                   const Numbers& start, const Numbers& sigma) {
  constexpr double kStep = 1e-6;
  ArmFit best{arm_residuals(model, sights, start, sigma).squaredNorm(), start};
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::VectorXd r = arm_residuals(model, sights, best.off, sigma);
    Eigen::MatrixXd J(r.size(), kNumbers);
    for (Eigen::Index k = 0; k < kNumbers; ++k) {
      Numbers shifted = best.off;
      shifted[k] += kStep;
      J.col(k) = (arm_residuals(model, sights, shifted, sigma) - r) / kStep;
    }
    Numbers delta = solve_symmetric(J.transpose().lazyProduct(J), -J.transpose() * r);
    ArmFit next = best;
    for (int halving = 0; halving < 8; ++halving, delta *= 0.5) {
      next.off = best.off + delta;
      next.chi2 = arm_residuals(model, sights, next.off, sigma).squaredNorm();
      if (next.chi2 < best.chi2) break;
    }
    if (!(next.chi2 < best.chi2 - 1e-6)) break;
    best = next;
  }
  return best;
}

/// A supposed cause: another kind of model or a suspect's freed numbers, and where to begin.
struct Supposition {
  const Suspect* suspect{nullptr};
  HealthCause cause{HealthCause::kSeveral};
  CellModel model;
  std::vector<Numbers> starts{Numbers::Zero()};
  ArmFit fit{};  ///< the best one from these

  std::size_t freed() const { return suspect == nullptr ? 0 : suspect->numbers.size(); }
};

/// Returns where to begin: gears exchanged, doubled or in degrees for radians, and quarter turns.
std::vector<double> starts_of(const Suspect& suspect) {
  constexpr double kDegreesForRadians = 180.0 / kPi;
  const int number = suspect.numbers[0];
  if (suspect.numbers.size() > 1) return {0.0};
  if (number >= kGearOff && number < kLinkOff)
    return {0.0, 1.0, -0.5, kDegreesForRadians - 1.0, 1.0 / kDegreesForRadians - 1.0};
  if (number < kGearOff || number == kTurnOff) return {0.0, kPi / 2.0, kPi, -kPi / 2.0};
  return {0.0};
}

std::vector<Supposition> freed_numbers(const CellModel& as_filed) {
  std::vector<Supposition> all;
  for (const Suspect& suspect : suspects()) {
    if (suspect.cause == HealthCause::kCameraTilted) continue;  // too small beside an arm's errors
    Supposition supposed{&suspect, suspect.cause, as_filed, {}};
    for (const double start : starts_of(suspect)) {
      supposed.starts.emplace_back(Numbers::Zero());
      supposed.starts.back()[suspect.numbers[0]] = start;
    }
    all.push_back(std::move(supposed));
  }
  return all;
}

/// Returns the model of an arm that stands with its other elbow, its end point where it should be.
CellModel with_other_elbow(const CellModel& as_filed, const ArmSight& sight) {
  const Eigen::Vector3d theta = as_filed.coupling.inverse() * sight.motors;
  const Eigen::Vector2d tip = as_filed.links_m[0] * rotation2d(theta[0]).col(0) +
                              as_filed.links_m[1] * rotation2d(theta[1]).col(0);
  const double ray = std::atan2(tip.y(), tip.x());
  const Eigen::Vector3d mirrored(2.0 * ray - theta[0], 2.0 * ray - theta[1], theta[2]);
  CellModel model = as_filed;
  model.zeros += as_filed.coupling * (mirrored - theta);
  return model;
}

/// Adds the suppositions of another kind than filed.
void add_changed_kinds(const CellModel& as_filed, const ArmSight& first,
                       std::vector<Supposition>& all) {
  const auto suppose = [&](HealthCause cause) -> CellModel& {
    all.push_back({nullptr, cause, as_filed});
    return all.back().model;
  };
  // Positions count from home, or from where the arm was homed by sight.
  for (const Eigen::Vector3d& origin : {as_filed.home, first.motors}) {
    const auto suppose_turns = [&](HealthCause cause) -> Eigen::Matrix3d& {
      CellModel& model = suppose(cause);
      model.home = origin;
      return model.gears;
    };
    constexpr HealthCause kDirections[] = {HealthCause::kDirection1, HealthCause::kDirection2,
                                           HealthCause::kDirection3};
    for (int motor = 0; motor < 3; ++motor) suppose_turns(kDirections[motor])(motor, motor) = -1.0;
    for (const auto& [cause, a, b] :
         {std::tuple(HealthCause::kExchanged12, 0, 1), std::tuple(HealthCause::kExchanged13, 0, 2),
          std::tuple(HealthCause::kExchanged23, 1, 2)}) {
      Eigen::Matrix3d& gears = suppose_turns(cause);
      gears(a, a) = gears(b, b) = 0.0;
      gears(a, b) = as_filed.pulses_per_rad[b] / as_filed.pulses_per_rad[a];
      gears(b, a) = 1.0 / gears(a, b);
    }
  }
  for (const int motor : {1, 2}) {
    double& rides = suppose(motor == 1 ? HealthCause::kCoupling2 : HealthCause::kCoupling3)
                        .coupling(motor, motor - 1);
    rides = rides == 0.0 ? -1.0 : 0.0;
  }
  suppose(HealthCause::kPositiveRotation).sense *= -1.0;
  if (std::abs(as_filed.links_m[0] - as_filed.links_m[1]) > kMillimetre)
    suppose(HealthCause::kLinksExchanged).links_m.reverseInPlace();
  suppose(HealthCause::kElbow) = with_other_elbow(as_filed, first);
  for (const double turn : {0.0, kPi / 2.0, kPi, -kPi / 2.0}) {
    suppose(HealthCause::kPictureMirrored).mirrored = true;
    all.back().starts[0][kTurnOff] = turn;
  }
}

/// Returns the best fit under a supposition. Every freed number costs the logarithm of the count of
/// coordinates, as in Schwarz's criterion.
ArmFit fit_supposed(const std::vector<ArmSight>& sights, const Supposition& supposed) {
  Numbers sigma = usual_deviations();
  if (supposed.suspect != nullptr)
    for (const int number : supposed.suspect->numbers) sigma[number] = kFree;
  if (supposed.cause == HealthCause::kPictureMirrored) sigma[kTurnOff] = kFree;
  ArmFit best;
  for (const Numbers& start : supposed.starts) {
    const ArmFit fit = fit_numbers(supposed.model, sights, start, sigma);
    if (fit.chi2 < best.chi2 - kClearlyBetter) best = fit;  // of equals the first, the smallest
  }
  const double count = 1.0 + static_cast<double>(supposed.freed());
  best.chi2 += count * std::log(4.0 * static_cast<double>(sights.size()));
  return best;
}

/// Returns the greatest distance at which the end point is seen from its place by the files.
double farthest(const CellModel& as_filed, const std::vector<ArmSight>& sights) {
  double most = 0.0;
  for (const ArmSight& sight : sights) {
    const LampPlaces expected = lamps_seen(as_filed, sight.motors);
    most = std::max(most,
                    0.5 * (sight.seen_B[0] + sight.seen_B[1] - expected[0] - expected[1]).norm());
  }
  return most;
}

/// Returns whether a joint would turn so many times as far as commanded as no mistaken gear makes
/// it, but for one in degrees instead of radians: something else is wrong then.
bool is_absurd(const Supposition& supposed) {
  constexpr double kMost = 30.0, kDegreesShare = 0.005;
  if (supposed.suspect == nullptr) return false;
  const int number = supposed.suspect->numbers[0];
  if (number < kGearOff || number >= kLinkOff) return false;
  const double times = std::abs(1.0 + supposed.fit.off[number]);
  return times > kMost && std::abs(times * kDegree - 1.0) > kDegreesShare;
}

HealthFinding finding_of(const Supposition& supposed, const CellModel& as_filed, double cost_m) {
  if (is_absurd(supposed))
    return {HealthCause::kSeveral, mm(cost_m), "mm", cost_m,
            "nothing that may be wrong with the arm explains what is seen; is the camera file that "
            "of this camera, for whole pictures of this size?"};
  if (supposed.suspect != nullptr) {
    Numbers off = supposed.fit.off;
    // A tool of equal lamps looks the same after half a turn.
    if (supposed.cause == HealthCause::kZero3)
      off[kZeroOff + 2] = std::remainder(off[kZeroOff + 2], kPi);
    return finding_of(*supposed.suspect, as_filed, off, cost_m);
  }
  return {supposed.cause, std::numeric_limits<double>::quiet_NaN(), "", cost_m,
          words(supposed.cause)};
}

constexpr int kCoordinates = 4;  // of the two lamps of a place

/// Returns true when noise explains squares that add up to this.
bool is_noise(double chi2, Eigen::Index coordinates) {
  return chi_square_tail(chi2, static_cast<int>(coordinates)) >= kFalseAlarm;
}

struct ChangeFit {
  const Suspect* suspect{nullptr};
  double chi2{0.0};
  double score{0.0};  ///< with a price for every number, twice that of Schwarz's criterion
  Numbers off;
};

Eigen::VectorXd differences(const std::vector<Revisit>& revisits) {
  Eigen::VectorXd d(kCoordinates * static_cast<Eigen::Index>(revisits.size()));
  for (std::size_t i = 0; i < revisits.size(); ++i)
    for (std::size_t lamp = 0; lamp < 2; ++lamp)
      d.segment<2>(static_cast<Eigen::Index>(kCoordinates * i + 2 * lamp)) =
          revisits[i].now_B[lamp] - revisits[i].then_B[lamp];
  return d;
}

/// Returns what a number displaces in each coordinate, to first order.
Eigen::MatrixXd displacements(const CellModel& model, const std::vector<Revisit>& revisits) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd J(kCoordinates * static_cast<Eigen::Index>(revisits.size()), kNumbers);
  for (std::size_t i = 0; i < revisits.size(); ++i) {
    const Revisit& at = revisits[i];
    const LampPlaces before = lamps_seen(model, at.motors);
    for (Eigen::Index k = 0; k < kNumbers; ++k) {
      const LampPlaces after = lamps_seen(model, at.motors, kStep * Numbers::Unit(k));
      const auto row = static_cast<Eigen::Index>(kCoordinates * i);
      J.block<2, 1>(row, k) = (after[0] - before[0]) / kStep;
      J.block<2, 1>(row + 2, k) = (after[1] - before[1]) / kStep;
    }
  }
  return J;
}

/// Changes of a sound arm between two visits, as columns of one standard deviation each: motors
/// warm its links by some kelvins, at 23 um/m each for aluminium, and shift its zeros.
Eigen::MatrixXd warmth(const CellModel& model, const Eigen::MatrixXd& J) {
  constexpr double kGrowth = 1e-4, kZeroShift = 0.001 * kDegree;
  Eigen::MatrixXd columns(J.rows(), 4);
  columns << kGrowth * J.middleCols<2>(kLinkOff) * model.links_m,
      kZeroShift * J.middleCols<3>(kZeroOff);
  return columns;
}

/// Differences and displacements in standard deviations of a sound cell, its arm warmed or not.
struct Whitened {
  Whitened(const CellModel& model, const std::vector<Revisit>& revisits, bool warms = true)
      : J(displacements(model, revisits)), d(differences(revisits)) {
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(d.size(), d.size());
    if (warms) {
      const Eigen::MatrixXd warm = warmth(model, J);
      covariance = warm * warm.transpose();
    }
    // The base stood anywhere at each place of a recording; places of a check follow each other.
    Eigen::MatrixX2d shift(d.size(), 2);
    for (std::size_t i = 0; i < revisits.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(kCoordinates * i);
      const auto& [scatter_m, wander_m] = std::pair(revisits[i].scatter_m, revisits[i].wander_m);
      const double scattered = 2.0 * scatter_m * scatter_m + wander_m * wander_m;
      shift.middleRows<kCoordinates>(at) = wander_m * Eigen::Matrix2d::Identity().replicate<2, 1>();
      for (Eigen::Index k = 0; k < kCoordinates; ++k) {
        covariance(at + k, at + k) += revisits[i].sigma_m * revisits[i].sigma_m + scattered;
        covariance(at + k, at + (k + 2) % kCoordinates) += scattered;  // the other lamp's
      }
    }
    covariance += shift.lazyProduct(shift.transpose());
    const Eigen::MatrixXd L = lower_factor(covariance).value();
    J = solve_lower(L, std::move(J));
    d = solve_lower(L, d);
  }

  Eigen::MatrixXd J;
  Eigen::VectorXd d;
};

ChangeFit fit_change(const Suspect& suspect, const Eigen::MatrixXd& J, const Eigen::VectorXd& d) {
  const auto count = static_cast<Eigen::Index>(suspect.numbers.size());
  Eigen::MatrixXd A(d.size(), count);
  for (Eigen::Index k = 0; k < count; ++k)
    A.col(k) = J.col(suspect.numbers[static_cast<std::size_t>(k)]);
  const Eigen::VectorXd found = solve_least_squares(A, d);
  ChangeFit fit{&suspect, (A * found - d).squaredNorm(), 0.0, Numbers::Zero()};
  for (Eigen::Index k = 0; k < count; ++k)
    fit.off[suspect.numbers[static_cast<std::size_t>(k)]] = found[k];
  fit.score = fit.chi2 + 2.0 * static_cast<double>(count) * std::log(static_cast<double>(d.size()));
  return fit;
}

/// Sorts by likelihood, but puts first the one that leaves little with the fewest numbers: the
/// remainder of a single change beyond first order looks like several small ones.
void put_likeliest_first(std::vector<ChangeFit>& fits, double little) {
  std::sort(fits.begin(), fits.end(),
            [](const ChangeFit& a, const ChangeFit& b) { return a.score < b.score; });
  // Where warmth hides most of a change, `little` is below what noise leaves; nothing with more
  // numbers may then outrank the likeliest.
  little = std::max(little, std::nextafter(fits.front().chi2, HUGE_VAL));
  std::stable_sort(fits.begin(), fits.end(), [&](const ChangeFit& a, const ChangeFit& b) {
    if (a.chi2 >= little || b.chi2 >= little) return a.chi2 < little && b.chi2 >= little;
    return a.suspect->numbers.size() < b.suspect->numbers.size();
  });
}

/// Returns whether a suspect's numbers are all among another's, which then always fits as well.
bool is_within(const Suspect& less, const Suspect& more) {
  return std::includes(more.numbers.begin(), more.numbers.end(), less.numbers.begin(),
                       less.numbers.end());
}

/// Returns how far a lamp seems to have moved, at most.
double cost_of(const std::vector<Revisit>& revisits) {
  double most = 0.0;
  for (const Revisit& at : revisits)
    for (std::size_t lamp = 0; lamp < 2; ++lamp)
      most = std::max(most, (at.now_B[lamp] - at.then_B[lamp]).norm());
  return most;
}

/// Returns a change that noise does not explain as warmth of the arm. It costs nothing to continue:
/// an arm is warm after an hour's work.
std::vector<HealthFinding> find_warmth(const CellModel& model,
                                       const std::vector<Revisit>& revisits) {
  constexpr double kWorthAWord_m = 50e-6;
  const double off_m = cost_of(revisits);
  const Eigen::VectorXd d = Whitened(model, revisits, false).d;
  if (off_m < kWorthAWord_m || is_noise(d.squaredNorm(), d.size())) return {};
  return {{HealthCause::kWarmth, mm(off_m), "mm", 0.0,
           fmt::format("{}: the tool is seen up to {:.3f} mm from where it was",
                       words(HealthCause::kWarmth), mm(off_m))}};
}

}  // namespace

std::vector<HealthFinding> find_arm_faults(const CellModel& as_filed,
                                           const std::vector<ArmSight>& sights) {
  if (sights.empty()) return {};
  const double sound = fit_supposed(sights, {nullptr, HealthCause::kSeveral, as_filed}).chi2;
  std::vector<Supposition> all = freed_numbers(as_filed);
  add_changed_kinds(as_filed, sights.front(), all);
  std::vector<Supposition> explanations;
  for (Supposition& supposed : all) {
    supposed.fit = fit_supposed(sights, supposed);
    if (supposed.fit.chi2 < sound - kLeastGain) explanations.push_back(std::move(supposed));
  }
  if (explanations.empty()) return {};
  std::sort(explanations.begin(), explanations.end(),
            [](const Supposition& a, const Supposition& b) { return a.fit.chi2 < b.fit.chi2; });
  const Supposition& best = explanations.front();
  const double cost_m = farthest(as_filed, sights);
  std::vector<HealthFinding> found{finding_of(best, as_filed, cost_m)};
  const double as_good = best.fit.chi2 + std::max(kAsLikely, kLittleLeft * (sound - best.fit.chi2));
  const auto second =
      std::find_if(explanations.begin() + 1, explanations.end(), [&](const Supposition& other) {
        return other.cause != best.cause && other.freed() == best.freed() &&
               other.fit.chi2 < as_good;
      });
  if (second != explanations.end()) found.push_back(finding_of(*second, as_filed, cost_m));
  return found;
}

bool has_changed(const CellModel& model, const std::vector<Revisit>& revisits) {
  const Eigen::VectorXd d = Whitened(model, revisits).d;
  return !is_noise(d.squaredNorm(), d.size()) && cost_of(revisits) >= kHarmless_m;
}

std::vector<std::size_t> farthest_off_first(const std::vector<Revisit>& revisits) {
  std::vector<std::size_t> order(revisits.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return cost_of({revisits[a]}) > cost_of({revisits[b]});
  });
  return order;
}

std::optional<std::size_t> stray_place(const CellModel& model,
                                       const std::vector<Revisit>& revisits) {
  constexpr std::size_t kFewestPlaces = 4, kStrayNumbers = 2;  // by which a stop misses
  if (revisits.size() < kFewestPlaces || !has_changed(model, revisits)) return std::nullopt;
  const std::size_t stray = farthest_off_first(revisits).front();
  std::vector<Revisit> others = revisits;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(stray));
  if (has_changed(model, others)) return std::nullopt;
  // A drift displaces all places, and that which is visited last farthest.
  const Whitened all(model, revisits);
  const double left = Whitened(model, others).d.squaredNorm();
  for (const Suspect& suspect : suspects())
    if (suspect.numbers.size() <= kStrayNumbers && fit_change(suspect, all.J, all.d).chi2 < left)
      return std::nullopt;
  return stray;
}

std::vector<HealthFinding> find_changes(const CellModel& model,
                                        const std::vector<Revisit>& revisits) {
  if (revisits.empty()) return {};
  if (!has_changed(model, revisits)) return find_warmth(model, revisits);
  const auto [J, d] = Whitened(model, revisits);
  const double cost_m = cost_of(revisits);
  std::vector<ChangeFit> fits;
  for (const Suspect& suspect : suspects()) fits.push_back(fit_change(suspect, J, d));
  const double little = kLittleLeft * d.squaredNorm();
  put_likeliest_first(fits, little);
  const ChangeFit& best = fits.front();
  // A cause is named as long as less than a third of the displacement is left unexplained.
  if (!is_noise(best.chi2, d.size()) && best.chi2 > 0.1 * d.squaredNorm())
    return {{HealthCause::kSeveral, mm(cost_m), "mm", cost_m,
             fmt::format("{}; the tool is seen up to {:.3f} mm from where it was",
                         words(HealthCause::kSeveral), mm(cost_m))}};
  std::vector<HealthFinding> found{finding_of(*best.suspect, model, best.off, cost_m)};
  const auto second = std::find_if(fits.begin() + 1, fits.end(), [&](const ChangeFit& fit) {
    const bool alike = fit.suspect->numbers.size() == best.suspect->numbers.size();
    return (fit.score < best.score + kAsLikely && !is_within(*best.suspect, *fit.suspect)) ||
           (alike && fit.chi2 < little);
  });
  if (second != fits.end())
    found.push_back(finding_of(*second->suspect, model, second->off, cost_m));
  return found;
}

std::vector<HealthFinding> find_play(const CellModel& model, const Revisit& from_both_sides,
                                     double allowed) {
  constexpr HealthCause kPlay[] = {HealthCause::kPlay1, HealthCause::kPlay2, HealthCause::kPlay3};
  const Eigen::MatrixXd J = displacements(model, {from_both_sides}).middleCols<3>(kZeroOff);
  const Eigen::VectorXd play = solve_least_squares(J, differences({from_both_sides}));
  std::vector<HealthFinding> found;
  for (Eigen::Index motor = 0; motor < 3; ++motor) {
    if (std::abs(play[motor]) <= allowed) continue;
    const double play_deg = std::abs(play[motor]) / kDegree;
    found.push_back({kPlay[motor], play_deg, "deg", cost_of({from_both_sides}),
                     fmt::format("{}: it is {:.3f} deg, allowed are {:.3f} deg",
                                 words(kPlay[motor]), play_deg, allowed / kDegree)});
  }
  return found;
}

}  // namespace planar
