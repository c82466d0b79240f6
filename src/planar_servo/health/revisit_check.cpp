#include "planar_servo/health/revisit_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/plane_geometry.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// One chance in 1,000, in standard deviations of a normal variable.
constexpr double kRare = 3.09;
/// Twice the logarithm of the odds of 20 to 1.
constexpr double kAsLikely = 6.0;
constexpr int kCoordinates = 4;  // of the two lamps of a place

/// Returns the quantile of chi-squared that is exceeded once in 1,000 times, after Wilson and
/// Hilferty.
double rare_chi2(Eigen::Index freedom) {
  const double spread = 2.0 / (9.0 * static_cast<double>(freedom));
  return static_cast<double>(freedom) * std::pow(1.0 - spread + kRare * std::sqrt(spread), 3);
}

using Columns4 = Eigen::Matrix<double, kCoordinates, Eigen::Dynamic>;

/// A cause and the columns by which its numbers displace the four coordinates of a place.
struct Change {
  Cause cause;
  const char* unit;
  double unit_size;
  std::function<Columns4(const Revisit&)> columns;
};

/// Returns the column of a change that moves each seen point by `move(from the foot)`.
template <typename Move>
Columns4 of_points(const CellModel& model, const Revisit& at, Eigen::Index count,
                   const Move& move) {
  Columns4 columns(kCoordinates, count);
  for (Eigen::Index lamp = 0; lamp < 2; ++lamp) {
    const Eigen::Vector2d from_foot = at.then_B[static_cast<std::size_t>(lamp)] - model.foot_B;
    for (Eigen::Index k = 0; k < count; ++k) columns.block<2, 1>(2 * lamp, k) = move(from_foot, k);
  }
  return columns;
}

Columns4 of_lamp(const CellModel& model, const Revisit& at, Eigen::Index lamp) {
  const Eigen::Vector3d theta = model.coupling.inverse() * at.motors;
  Columns4 columns = Columns4::Zero(kCoordinates, 2);
  columns.block<2, 2>(2 * lamp, 0) = rotation2d(model.sense * theta[2]);
  return columns;
}

Columns4 of_zero(const CellModel& model, const Revisit& at, int motor) {
  constexpr double kStep = 1e-6;
  CellModel shifted = model;
  shifted.zeros_rad[motor] += kStep;
  const LampPlaces before = lamps_seen(model, at.motors), after = lamps_seen(shifted, at.motors);
  Columns4 column(kCoordinates, 1);
  column << after[0] - before[0], after[1] - before[1];
  return column / kStep;
}

std::vector<Change> changes(const CellModel& model) {
  const auto points = [&model](Eigen::Index count, auto move) {
    return [&model, count, move](const Revisit& at) { return of_points(model, at, count, move); };
  };
  std::vector<Change> all{
      {Cause::kCameraShifted, "mm", kMillimetre,
       points(2, [](const Eigen::Vector2d&,
                    Eigen::Index k) { return Eigen::Vector2d(Eigen::Vector2d::Unit(k)); })},
      {Cause::kCameraTurned, "deg", kDegree,
       points(1, [](const Eigen::Vector2d& p,
                    Eigen::Index) { return Eigen::Vector2d(-p.y(), p.x()); })},
      {Cause::kCameraCloser, "%", 0.01,
       points(1, [](const Eigen::Vector2d& p, Eigen::Index) { return p; })},
      {Cause::kCameraTilted, "mm at most", kMillimetre,
       points(4,
              [](const Eigen::Vector2d& p, Eigen::Index k) {
                // To first order a tilt shifts the picture, and stretches it along one direction.
                return k < 2 ? Eigen::Vector2d(p[k] * p)
                             : Eigen::Vector2d(Eigen::Vector2d::Unit(k - 2));
              })},
      {Cause::kLamp1Moved, "mm", kMillimetre,
       [&model](const Revisit& at) { return of_lamp(model, at, 0); }},
      {Cause::kLamp2Moved, "mm", kMillimetre,
       [&model](const Revisit& at) { return of_lamp(model, at, 1); }}};
  constexpr Cause kZeros[] = {Cause::kZero1, Cause::kZero2, Cause::kZero3};
  for (int motor = 0; motor < 3; ++motor)
    all.push_back({kZeros[motor], "deg", kDegree,
                   [&model, motor](const Revisit& at) { return of_zero(model, at, motor); }});
  return all;
}

struct ChangeFit {
  const Change* change{nullptr};
  double chi2{0.0};
  double score{0.0};  ///< with a price for every number, twice that of Schwarz's criterion
  Eigen::VectorXd numbers;
};

Eigen::VectorXd differences(const std::vector<Revisit>& revisits) {
  Eigen::VectorXd d(kCoordinates * static_cast<Eigen::Index>(revisits.size()));
  for (std::size_t i = 0; i < revisits.size(); ++i)
    for (std::size_t lamp = 0; lamp < 2; ++lamp)
      d.segment<2>(static_cast<Eigen::Index>(kCoordinates * i + 2 * lamp)) =
          (revisits[i].now_B[lamp] - revisits[i].then_B[lamp]) / revisits[i].sigma_m;
  return d;
}

ChangeFit fit_change(const Change& change, const std::vector<Revisit>& revisits,
                     const Eigen::VectorXd& d) {
  Eigen::MatrixXd A(d.size(), change.columns(revisits.front()).cols());
  for (std::size_t i = 0; i < revisits.size(); ++i)
    A.middleRows<kCoordinates>(static_cast<Eigen::Index>(kCoordinates * i)) =
        change.columns(revisits[i]) / revisits[i].sigma_m;
  ChangeFit fit{&change, 0.0, 0.0, solve_least_squares(A, d)};
  fit.chi2 = (A * fit.numbers - d).squaredNorm();
  fit.score =
      fit.chi2 + 2.0 * static_cast<double>(A.cols()) * std::log(static_cast<double>(d.size()));
  return fit;
}

/// Returns how far a lamp seems to have moved, at most.
double cost_of(const std::vector<Revisit>& revisits) {
  double most = 0.0;
  for (const Revisit& at : revisits)
    for (std::size_t lamp = 0; lamp < 2; ++lamp)
      most = std::max(most, (at.now_B[lamp] - at.then_B[lamp]).norm());
  return most;
}

HealthFinding finding_of(const ChangeFit& fit, double cost_m) {
  HealthFinding finding{fit.change->cause, 0.0, fit.change->unit, cost_m, {}};
  const Eigen::VectorXd& numbers = fit.numbers;
  const double size = numbers.size() == 1   ? numbers[0]
                      : numbers.size() == 2 ? numbers.norm()
                                            : cost_m;
  finding.size = size / fit.change->unit_size;
  finding.what = fmt::format("{} by {:.3g} {}", words(finding.cause), finding.size, finding.unit);
  return finding;
}

}  // namespace

std::vector<HealthFinding> find_changes(const CellModel& model,
                                        const std::vector<Revisit>& revisits) {
  if (revisits.empty()) return {};
  const Eigen::VectorXd d = differences(revisits);
  const double cost_m = cost_of(revisits);
  if (d.squaredNorm() < rare_chi2(d.size()) || cost_m < kHarmless_m) return {};
  const std::vector<Change> all = changes(model);
  std::vector<ChangeFit> fits;
  for (const Change& change : all) fits.push_back(fit_change(change, revisits, d));
  std::sort(fits.begin(), fits.end(),
            [](const ChangeFit& a, const ChangeFit& b) { return a.score < b.score; });
  const ChangeFit& best = fits.front();
  // A cause is named as long as less than a third of the displacement is left unexplained.
  if (best.chi2 > std::max(rare_chi2(d.size()), 0.1 * d.squaredNorm()))
    return {{Cause::kSeveral, cost_m / kMillimetre, "mm", cost_m,
             fmt::format("{}; the tool is seen up to {:.3f} mm from where it was",
                         words(Cause::kSeveral), cost_m / kMillimetre)}};
  std::vector<HealthFinding> found{finding_of(best, cost_m)};
  if (fits[1].score < best.score + kAsLikely) found.push_back(finding_of(fits[1], cost_m));
  return found;
}

}  // namespace planar
