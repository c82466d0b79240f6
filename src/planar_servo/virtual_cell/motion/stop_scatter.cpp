#include "planar_servo/virtual_cell/motion/stop_scatter.h"

#include <cmath>

#include "planar_servo/core/units.h"
#include "planar_servo/virtual_cell/random.h"

namespace planar {
namespace {

constexpr double kStop_s = 0.1;
constexpr double kShortMove = 1.0 * kMillimetre;
// One stop in ten scatters twice as far, which makes the tails heavier than normal ones.
constexpr double kWildShare = 0.1, kWild = 2.0;

}  // namespace

Eigen::Vector2d StopScatter::at_rest(const Eigen::Vector2d& p_m, bool negative) const {
  Random random(seed_, RandomStream::kScatter, stops_);
  const bool wild = random.uniform(0.0, 1.0) < kWildShare;
  const double rms = std::sqrt(1.0 - kWildShare + kWildShare * kWild * kWild);
  double sigma_m = truth_.sigma_m * (wild ? kWild : 1.0) / rms;
  if (last_stop_m_ && (p_m - *last_stop_m_).norm() < kShortMove)
    sigma_m *= truth_.short_move_factor;
  if (negative) sigma_m *= truth_.negative_factor;
  const double x = random.normal(), y = random.normal();
  return sigma_m * Eigen::Vector2d(x, y);
}

void StopScatter::leave(const Eigen::Vector2d& p_m, bool negative, double rested_s) {
  kept_m_ = at_rest(p_m, negative);
  if (rested_s < kStop_s) return;
  ++stops_;
  last_stop_m_ = p_m;
}

}  // namespace planar
