#include "planar_servo/virtual_cell/virtual_lens.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/random.h"

namespace planar {
namespace {

constexpr int kWaves = 16;
constexpr int kStepsPerTime = 8;  // between two steps the shift goes straight on
constexpr int kRemembered = 6 * kStepsPerTime;
// Keeps the draw of the waves apart from those of the steps.
constexpr std::uint64_t kWaveDraw = std::numeric_limits<std::uint64_t>::max();

constexpr int kMaxIterations = 20;
constexpr double kConverged = 1e-14;  // in normalised coordinates: about 1e-10 px

/// Returns d(ideal)/d(distorted) of the inverse polynomial.
Eigen::Matrix2d inverse_jacobian(const CameraTruth& truth, const Eigen::Vector2d& d) {
  const double s = d.squaredNorm();
  const auto& [a1, a2, a3] = truth.radial;
  const auto& [p1, p2] = truth.decentring;
  const double scale = 1.0 + s * (a1 + s * (a2 + s * a3));
  const double slope = a1 + s * (2.0 * a2 + s * 3.0 * a3);
  const double cross = 2.0 * (p1 * d.x() + p2 * d.y());
  Eigen::Matrix2d J = scale * Eigen::Matrix2d::Identity() + 2.0 * slope * d * d.transpose();
  J(0, 0) += 2.0 * p1 * d.y() + 6.0 * p2 * d.x();
  J(0, 1) += cross;
  J(1, 0) += cross;
  J(1, 1) += 6.0 * p1 * d.y() + 2.0 * p2 * d.x();
  return J;
}

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

VirtualLens::VirtualLens(const CameraTruth& truth, std::uint64_t seed)
    : truth_(truth), p_BC_(truth.X_CB.inverse().translation()) {
  if (truth.air) air_.emplace(*truth.air, seed);
}

double VirtualLens::still_s() const {
  constexpr double kWithoutAir_s = 1.0;
  return air_ ? std::min(air_->still_s(), kWithoutAir_s) : kWithoutAir_s;
}

Eigen::Vector2d VirtualLens::ideal_from_distorted(const Eigen::Vector2d& d) const {
  const double s = d.squaredNorm();
  const auto& [a1, a2, a3] = truth_.radial;
  const auto& [p1, p2] = truth_.decentring;
  const Eigen::Vector2d decentring(2.0 * p1 * d.x() * d.y() + p2 * (s + 2.0 * d.x() * d.x()),
                                   p1 * (s + 2.0 * d.y() * d.y()) + 2.0 * p2 * d.x() * d.y());
  return d * (1.0 + s * (a1 + s * (a2 + s * a3))) + decentring;
}

std::optional<Eigen::Vector2d> VirtualLens::distorted_from_ideal(
    const Eigen::Vector2d& ideal) const {
  Eigen::Vector2d d = ideal;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Eigen::Matrix2d J = inverse_jacobian(truth_, d);
    if (!(J.determinant() > 0.0)) return std::nullopt;
    const Eigen::Vector2d step = J.inverse() * (ideal - ideal_from_distorted(d));
    d += step;
    if (step.squaredNorm() < kConverged * kConverged) return d;
  }
  return std::nullopt;
}

Eigen::Vector2d VirtualLens::warp_px(const Eigen::Vector2d& w_px) const {
  Eigen::Vector2d shift(0.0, 0.0);
  for (const WarpBump& bump : truth_.warp) {
    const double distance = (w_px - bump.center_px).squaredNorm();
    shift += bump.amplitude_px * std::exp(-0.5 * distance / (bump.sigma_px * bump.sigma_px));
  }
  return shift;
}

std::optional<Eigen::Vector2d> VirtualLens::project(const Eigen::Vector3d& p_B, double t_s) const {
  const Eigen::Vector3d p_C = truth_.X_CB * p_B;
  if (!(p_C.z() > 0.0)) return std::nullopt;
  const auto distorted = distorted_from_ideal(p_C.head<2>() / p_C.z());
  if (!distorted) return std::nullopt;
  const Eigen::Vector2d w_px = truth_.focal_px.cwiseProduct(*distorted) + truth_.center_px;
  const Eigen::Vector2d drifted_px = w_px + warp_px(w_px) + truth_.drift_px_per_h * (t_s / kHour);
  const Eigen::Vector2d uv_px =
      truth_.warming ? warmed_px(drifted_px, *truth_.warming, t_s) : drifted_px;
  return air_ ? uv_px + air_->shift_px(uv_px, t_s) : uv_px;
}

Eigen::Vector2d VirtualLens::warmed_px(const Eigen::Vector2d& w_px, const WarmingTruth& warming,
                                       double t_s) const {
  const double way = 1.0 - std::exp(-t_s / warming.time_constant_s);
  const Eigen::Matrix2d turn = rotation2d(way * warming.turn_rad);
  return truth_.center_px + (1.0 + way * warming.growth) * turn * (w_px - truth_.center_px) +
         way * warming.shift_px;
}

}  // namespace planar
