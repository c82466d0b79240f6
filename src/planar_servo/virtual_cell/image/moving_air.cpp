#include "planar_servo/virtual_cell/image/moving_air.h"

#include <cmath>
#include <limits>

#include "planar_servo/core/units.h"
#include "planar_servo/virtual_cell/random.h"

namespace planar {
namespace {

constexpr int kWaves = 16;
constexpr int kStepsPerTime = 8;  // between two steps the shift goes straight on
constexpr int kRemembered = 6 * kStepsPerTime;
// Keeps the draw of the waves apart from those of the steps.
constexpr std::uint64_t kWaveDraw = std::numeric_limits<std::uint64_t>::max();

}  // namespace

MovingAir::MovingAir(const AirTruth& truth, std::uint64_t seed) : truth_(truth), seed_(seed) {
  Random random(seed, RandomStream::kAir, kWaveDraw);
  for (int i = 0; i < kWaves; ++i) {
    const double u = random.normal(), v = random.normal();
    waves_.push_back({Eigen::Vector2d(u, v) / truth.length_px, random.uniform(-kPi, kPi)});
  }
}

double MovingAir::still_s() const {
  return truth_.time_s / kStepsPerTime;
}

MovingAir::Amplitudes MovingAir::at_step(std::int64_t step) const {
  const double kept = std::exp(-1.0 / kStepsPerTime);
  Amplitudes sum = Amplitudes::Zero(2, kWaves);
  for (std::int64_t past = step - kRemembered; past <= step; ++past) {
    Random random(seed_, RandomStream::kAir, static_cast<std::uint64_t>(past + kRemembered));
    sum *= kept;
    for (Eigen::Index i = 0; i < sum.size(); ++i) sum(i) += random.normal();
  }
  return std::sqrt(1.0 - kept * kept) * sum;
}

const MovingAir::Amplitudes& MovingAir::amplitudes(double t_s) const {
  if (asked_s_ == t_s) return asked_;
  const double steps = t_s / still_s();
  const double before = std::floor(steps);
  const auto step = static_cast<std::int64_t>(before);
  const double way = steps - before;
  asked_ = (1.0 - way) * at_step(step) + way * at_step(step + 1);
  asked_s_ = t_s;
  return asked_;
}

Eigen::Vector2d MovingAir::shift_px(const Eigen::Vector2d& w_px, double t_s) const {
  const Amplitudes& amplitude = amplitudes(t_s);
  Eigen::Vector2d shift(0.0, 0.0);
  for (std::size_t i = 0; i < waves_.size(); ++i)
    shift += amplitude.col(static_cast<Eigen::Index>(i)) *
             std::cos(waves_[i].per_px.dot(w_px) + waves_[i].phase_rad);
  return truth_.sigma_px * std::sqrt(2.0 / kWaves) * shift;
}

}  // namespace planar
