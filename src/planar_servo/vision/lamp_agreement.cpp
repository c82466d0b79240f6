#include "planar_servo/vision/lamp_agreement.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

/// One look in a million differs by so many deviations, estimated from a few.
constexpr double kDeviations = 6.0;
/// Looks hardly scatter less than by the noise of the best lamps: a micrometre, seen 40 mm apart.
constexpr double kLeast_m = 1e-6, kLeastTurn = 25e-6;

bool is_like(double value, const std::deque<double>& others, double least) {
  const double middle = median({others.begin(), others.end()});
  std::vector<double> off;
  off.reserve(others.size());
  for (const double other : others) off.push_back(std::abs(other - middle));
  constexpr double kMedianOfOne = 0.6745;
  return std::abs(value - middle) <
         kDeviations * std::max(least, median(std::move(off)) / kMedianOfOne);
}

}  // namespace

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

}  // namespace planar
