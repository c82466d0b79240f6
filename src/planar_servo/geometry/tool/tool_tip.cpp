#include "planar_servo/geometry/tool/tool_tip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr Eigen::Index kUnknowns = 4;  // p_TE and the mark

/// A solution for unit deviations.
struct Solution {
  Eigen::Vector4d x;
  Eigen::Matrix4d cofactor;
  Eigen::VectorXd residuals;
};

std::optional<Solution> solve(const std::vector<TipAtMark>& poses) {
  const auto n = static_cast<Eigen::Index>(poses.size());
  Eigen::MatrixXd A(2 * n, kUnknowns);
  Eigen::VectorXd b(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const TipPose& pose = poses[i].pose;
    A.middleRows<2>(2 * i) << rotation2d(pose.phi), -Eigen::Matrix2d::Identity();
    b.segment<2>(2 * i) = -pose.p;
  }
  const auto inverse =
      solve_positive(A.transpose() * A, Eigen::MatrixXd::Identity(kUnknowns, kUnknowns), 1e-9);
  if (!inverse) return std::nullopt;
  const Eigen::Vector4d x = *inverse * (A.transpose() * b);
  return Solution{x, *inverse, b - A * x};
}

/// Returns the chance that noise of `sigma` explains the residuals.
double chance(const Solution& solution, double sigma) {
  const int freedom = static_cast<int>(solution.residuals.size() - kUnknowns);
  return freedom > 0 ? chi_square_tail(solution.residuals.squaredNorm() / (sigma * sigma), freedom)
                     : 1.0;
}

std::size_t directions_apart(const std::vector<TipAtMark>& poses) {
  std::vector<double> apart;
  for (const TipAtMark& at : poses)
    if (std::all_of(apart.begin(), apart.end(), [&](double phi) {
          return std::abs(wrap_angle(at.pose.phi - phi)) >= kApartDirections;
        }))
      apart.push_back(at.pose.phi);
  return apart.size();
}

/// Returns the only pose without which the others agree.
std::optional<std::size_t> slipped(const std::vector<TipAtMark>& poses, double sigma) {
  std::optional<std::size_t> odd;
  if (poses.size() < 4) return odd;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    std::vector<TipAtMark> rest = poses;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    const auto without = solve(rest);
    if (!without || chance(*without, sigma) < kFalseAlarm) continue;
    if (odd) return std::nullopt;
    odd = i;
  }
  return odd;
}

[[noreturn]] void refuse_slip(const std::vector<TipAtMark>& poses, const Solution& all,
                              double sigma) {
  const double rms_m =
      std::sqrt(all.residuals.squaredNorm() / static_cast<double>(all.residuals.size()));
  const auto odd = slipped(poses, sigma);
  throw WorkError(
      {fmt::format("the poses miss one mark by {:.3f} mm rms, which {:.3f} mm of scatter does not "
                   "explain{}",
                   mm(rms_m), mm(sigma),
                   odd ? "; without " + poses[*odd].id + " the others agree"
                       : "; no single one can be told to be wrong"),
       odd ? "bring the tip to the mark again there"
           : "bring the tip to the mark again in four directions, and see that neither slips",
       "", Cause::kContradiction});
}

}  // namespace

TaughtTip teach_tip(const std::vector<TipAtMark>& poses, double sigma) {
  constexpr std::size_t kLeast = 3;
  if (const std::size_t apart = directions_apart(poses); apart < kLeast)
    throw InputError(Refusal{
        fmt::format("the tip was brought to the mark in {} direction{} that differ by {:.0f} deg "
                    "or more; three are the least that show a slip",
                    apart, apart == 1 ? "" : "s", kApartDirections / kDegree),
        "turn joint 3 between them, best by a quarter turn each", "", Cause::kInsufficient});
  const auto solution = solve(poses);
  if (!solution) throw WorkError("the poses do not determine the tip", Cause::kInsufficient);
  if (chance(*solution, sigma) < kFalseAlarm) refuse_slip(poses, *solution, sigma);
  TaughtTip taught;
  const auto freedom = static_cast<double>(solution->residuals.size() - kUnknowns);
  const double found = freedom > 0.0 ? std::sqrt(solution->residuals.squaredNorm() / freedom) : 0.0;
  taught.sigma = std::max(sigma, found);
  taught.tip.p_TE = solution->x.head<2>();
  taught.tip.covariance = taught.sigma * taught.sigma * solution->cofactor.topLeftCorner<2, 2>();
  taught.mark_B = solution->x.tail<2>();
  for (Eigen::Index i = 0; i < solution->residuals.size(); i += 2)
    taught.residuals.emplace_back(solution->residuals.segment<2>(i));
  return taught;
}

TipMiss miss_of(const TaughtTip& taught, const TipPose& pose) {
  const Eigen::Vector2d tip = pose.p + rotation2d(pose.phi) * taught.tip.p_TE;
  // The mark is as uncertain as the tip, and a pose more than either.
  return {tip - taught.mark_B,
          std::sqrt(taught.sigma * taught.sigma + taught.tip.covariance.trace())};
}

}  // namespace planar
