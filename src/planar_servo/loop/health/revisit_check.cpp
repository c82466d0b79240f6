#include "planar_servo/loop/health/revisit_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

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
    covariance += shift * shift.transpose();
    const Eigen::MatrixXd L = *lower_factor(covariance);
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
  constexpr std::size_t kFewestPlaces = 4;
  if (revisits.size() < kFewestPlaces || !has_changed(model, revisits)) return std::nullopt;
  const std::size_t stray = farthest_off_first(revisits).front();
  std::vector<Revisit> others = revisits;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(stray));
  if (has_changed(model, others)) return std::nullopt;
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
