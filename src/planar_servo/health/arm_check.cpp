#include "planar_servo/health/arm_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/plane_geometry.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// The numbers of a model that may be off, in the order of a vector of them.
enum Number { kZeros = 0, kGears = 3, kLinks = 6, kShift = 8, kTurn = 10, kGrowth = 11, kNumbers };
using Numbers = Eigen::Matrix<double, kNumbers, 1>;

/// What the numbers of a sound cell are off by, one standard deviation: zeros that were set by eye,
/// gears and links as they are made, a workplane that was calibrated.
Numbers usual_deviations() {
  Numbers sigma;
  sigma.segment<3>(kZeros).setConstant(0.15 * kDegree);
  sigma.segment<3>(kGears).setConstant(5e-4);
  sigma.segment<2>(kLinks).setConstant(0.7 * kMillimetre);
  sigma.segment<2>(kShift).setConstant(0.1 * kMillimetre);
  sigma[kTurn] = 0.02 * kDegree;
  sigma[kGrowth] = 2e-4;
  return sigma;
}

constexpr double kFree = 1e3;  ///< the deviation of a freed number: radians, metres or a ratio
constexpr int kMaxSteps = 25;
constexpr double kClearlyBetter = 0.1;
constexpr double kLeastGain = 16.0;  ///< twice the logarithm of the odds

CellModel with(CellModel model, const Numbers& off) {
  model.zeros_rad += off.segment<3>(kZeros);
  model.gears = model.gears.cwiseProduct((off.segment<3>(kGears).array() + 1.0).matrix());
  model.links_m += off.segment<2>(kLinks);
  model.shift_m += off.segment<2>(kShift);
  model.turn += off[kTurn];
  model.growth += off[kGrowth];
  return model;
}

/// Returns the sights' residuals in standard deviations, each pair in the order that fits better,
/// and then how far each number is off, in the same unit.
Eigen::VectorXd arm_residuals(const CellModel& model, const std::vector<ArmSight>& sights,
                              const Numbers& off, const Numbers& sigma) {
  const auto n = static_cast<Eigen::Index>(sights.size());
  Eigen::VectorXd r(4 * n + kNumbers);
  const CellModel moved = with(model, off);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ArmSight& sight = sights[static_cast<std::size_t>(i)];
    const LampPlaces expected = lamps_seen(moved, sight.motors);
    const Eigen::Vector2d half = 0.5 * (expected[1] - expected[0]);
    // Only the direction counts: how far the lamps are apart tells nothing of the arm.
    Eigen::Vector2d seen_half = half.norm() * (sight.seen_B[1] - sight.seen_B[0]).normalized();
    if (seen_half.dot(half) < 0.0) seen_half = -seen_half;
    r.segment<2>(4 * i) = 0.5 * (sight.seen_B[0] + sight.seen_B[1] - expected[0] - expected[1]) /
                          sight.middle_sigma_m;
    r.segment<2>(4 * i + 2) = (seen_half - half) / sight.half_sigma_m;
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
    Numbers delta = solve_symmetric(J.transpose() * J, -J.transpose() * r);
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

/// Supposes one cause: the model changed in kind, numbers freed, and where their search begins.
struct Supposition {
  Cause cause{Cause::kSeveral};
  std::function<void(CellModel&)> change;
  std::vector<int> freed;
  std::vector<Numbers> starts{Numbers::Zero()};
};

Supposition in_kind(Cause cause, std::function<void(CellModel&)> change) {
  return {cause, std::move(change), {}};
}

Supposition freed(Cause cause, int number, const std::vector<double>& starts) {
  Supposition supposed{cause, {}, {number}, {}};
  for (const double start : starts) {
    supposed.starts.emplace_back(Numbers::Zero());
    supposed.starts.back()[number] = start;
  }
  return supposed;
}

void suppose_directions_and_coupling(std::vector<Supposition>& all) {
  constexpr Cause kDirections[] = {Cause::kDirection1, Cause::kDirection2, Cause::kDirection3};
  for (int joint = 0; joint < 3; ++joint)
    all.push_back(
        in_kind(kDirections[joint], [joint](CellModel& model) { model.gears[joint] = -1.0; }));
  for (const int motor : {1, 2})
    all.push_back(
        in_kind(motor == 1 ? Cause::kCoupling2 : Cause::kCoupling3, [motor](CellModel& model) {
          double& rides = model.coupling(motor, motor - 1);
          rides = rides == 0.0 ? -1.0 : 0.0;
        }));
  all.push_back(
      in_kind(Cause::kPositiveRotation, [](CellModel& model) { model.sense = -model.sense; }));
}

/// The elbow of an arm whose zeros of joints 1 and 2 are off so that the end point stays.
Supposition other_elbow(const CellModel& as_filed, const ArmSight& sight) {
  const Eigen::Vector3d theta = as_filed.coupling.inverse() * sight.motors;
  const Eigen::Vector2d link1 = as_filed.links_m[0] * rotation2d(theta[0]).col(0);
  const Eigen::Vector2d tip = link1 + as_filed.links_m[1] * rotation2d(theta[1]).col(0);
  const double ray = std::atan2(tip.y(), tip.x());
  const Eigen::Vector3d mirrored(2.0 * ray - theta[0], 2.0 * ray - theta[1], theta[2]);
  Supposition supposed{Cause::kElbow, {}, {kZeros, kZeros + 1}};
  supposed.starts[0].segment<3>(kZeros) = as_filed.coupling * mirrored - as_filed.coupling * theta;
  return supposed;
}

std::vector<Supposition> suppositions(const CellModel& as_filed, const ArmSight& first) {
  constexpr double kDegreesForRadians = 180.0 / kPi;
  const std::vector<double> ratios{0.0, 1.0, -0.5, kDegreesForRadians - 1.0,
                                   1.0 / kDegreesForRadians - 1.0};
  const std::vector<double> turns{0.0, kPi / 2.0, kPi, -kPi / 2.0};
  std::vector<Supposition> all;
  suppose_directions_and_coupling(all);
  for (const Cause cause : {Cause::kGear1, Cause::kGear2, Cause::kGear3})
    all.push_back(
        freed(cause, kGears + static_cast<int>(cause) - static_cast<int>(Cause::kGear1), ratios));
  for (const Cause cause : {Cause::kZero1, Cause::kZero2, Cause::kZero3})
    all.push_back(
        freed(cause, kZeros + static_cast<int>(cause) - static_cast<int>(Cause::kZero1), turns));
  all.push_back(freed(Cause::kLink1, kLinks, {0.0}));
  all.push_back(freed(Cause::kLink2, kLinks + 1, {0.0}));
  if (std::abs(as_filed.links_m[0] - as_filed.links_m[1]) > 1e-3)
    all.push_back(in_kind(Cause::kLinksExchanged,
                          [](CellModel& model) { std::swap(model.links_m[0], model.links_m[1]); }));
  all.push_back(other_elbow(as_filed, first));
  Supposition mirrored =
      in_kind(Cause::kPictureMirrored, [](CellModel& model) { model.mirrored = true; });
  mirrored.freed = {kTurn};
  mirrored.starts = freed(Cause::kPictureMirrored, kTurn, turns).starts;
  all.push_back(mirrored);
  all.push_back({Cause::kCameraShifted, {}, {kShift, kShift + 1}});
  all.push_back(freed(Cause::kCameraTurned, kTurn, turns));
  all.push_back(freed(Cause::kCameraCloser, kGrowth, {0.0}));
  return all;
}

/// Returns the best fit under a supposition. Every freed number costs the logarithm of the count of
/// coordinates, as in Schwarz's criterion.
ArmFit fit_supposed(const CellModel& as_filed, const std::vector<ArmSight>& sights,
                    const Supposition& supposed) {
  CellModel model = as_filed;
  if (supposed.change) supposed.change(model);
  Numbers sigma = usual_deviations();
  for (const int number : supposed.freed) sigma[number] = kFree;
  ArmFit best;
  for (const Numbers& start : supposed.starts) {
    const ArmFit fit = fit_numbers(model, sights, start, sigma);
    if (fit.chi2 < best.chi2 - kClearlyBetter) best = fit;  // of equals the first, the smallest
  }
  const double count = 1.0 + static_cast<double>(supposed.freed.size());
  best.chi2 += count * std::log(4.0 * static_cast<double>(sights.size()));
  return best;
}

/// Writes the size of a cause in the unit that a person would measure it in.
void set_size(HealthFinding& finding, const Supposition& supposed, const Numbers& off,
              const CellModel& as_filed) {
  finding.size = std::numeric_limits<double>::quiet_NaN();
  finding.what = words(finding.cause);
  if (supposed.freed.empty() || finding.cause == Cause::kElbow ||
      finding.cause == Cause::kPictureMirrored)
    return;
  const int number = supposed.freed.front();
  const double value = off[number];
  if (number >= kShift && number < kTurn) {
    finding.size = off.segment<2>(kShift).norm() / kMillimetre;
    finding.unit = "mm";
    finding.what += fmt::format(" by {:.2f} mm", finding.size);
  } else if (number >= kLinks && number < kShift) {
    finding.size = value / kMillimetre;
    finding.unit = "mm";
    finding.what += fmt::format(": it measures {:.1f} mm, not {:.1f} mm",
                                (as_filed.links_m[number - kLinks] + value) / kMillimetre,
                                as_filed.links_m[number - kLinks] / kMillimetre);
  } else if (number >= kGears && number < kLinks) {
    finding.size = 1.0 + value;
    finding.unit = "turns per turn commanded";
    finding.what += fmt::format(": the joint turns {:.4f} times as far as commanded", 1.0 + value);
  } else if (number == kGrowth) {
    finding.size = 100.0 * value;
    finding.unit = "%";
    finding.what += fmt::format(": the picture grew by {:.3f} %", finding.size);
  } else {
    finding.size = wrap_angle(value) / kDegree;
    finding.unit = "deg";
    finding.what += fmt::format(": it is off by {:.2f} deg", finding.size);
  }
}

/// Returns how far the end point is seen from where the files say, at most.
double farthest(const CellModel& as_filed, const std::vector<ArmSight>& sights) {
  double most = 0.0;
  for (const ArmSight& sight : sights) {
    const LampPlaces expected = lamps_seen(as_filed, sight.motors);
    most = std::max(most,
                    0.5 * (sight.seen_B[0] + sight.seen_B[1] - expected[0] - expected[1]).norm());
  }
  return most;
}

}  // namespace

std::optional<HealthFinding> find_arm_fault(const CellModel& as_filed,
                                            const std::vector<ArmSight>& sights) {
  if (sights.empty()) return std::nullopt;
  const ArmFit sound = fit_supposed(as_filed, sights, Supposition());
  const Supposition* likeliest = nullptr;
  const std::vector<Supposition> all = suppositions(as_filed, sights.front());
  ArmFit best = sound;
  best.chi2 -= kLeastGain;
  for (const Supposition& supposed : all) {
    const ArmFit fit = fit_supposed(as_filed, sights, supposed);
    if (!(fit.chi2 < best.chi2)) continue;
    best = fit;
    likeliest = &supposed;
  }
  if (likeliest == nullptr) return std::nullopt;
  HealthFinding finding;
  finding.cause = likeliest->cause;
  finding.cost_m = farthest(as_filed, sights);
  set_size(finding, *likeliest, best.off, as_filed);
  return finding;
}

}  // namespace planar
