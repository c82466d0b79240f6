#include "planar_servo/calibration/workplane_calibration.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"

namespace planar {
namespace {

const Eigen::Vector2d kOffset_ref(0.012, -0.031);

std::vector<SweepPoint> sweeps(double noise, double range) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0.0, noise);
  const std::vector<Eigen::Vector2d> axes{{0.3, 0.1}, {-0.2, 0.4}};
  std::vector<SweepPoint> points;
  for (int i = 0; i < 20; ++i) {
    const int sweep = i % 2;
    const double phi = range * i / 20.0;
    const Eigen::Vector2d error{normal(random), normal(random)};
    points.push_back({sweep, phi, axes[sweep] + rotation2d(phi) * kOffset_ref + error});
  }
  return points;
}

}  // namespace

TEST_CASE("Two sweeps in different places give one offset") {
  const SweepOffset fit = fit_sweep_offset(sweeps(0.0, 1.5 * kPi));
  CHECK((fit.offset - kOffset_ref).norm() < 1e-15);
  for (const double residual : fit.residuals) CHECK(residual < 1e-15);
}

TEST_CASE("A noisy sweep gives the offset within its stated deviation") {
  constexpr double kNoise = 0.02 * kMillimetre;
  const SweepOffset fit = fit_sweep_offset(sweeps(kNoise, 2.0 * kPi));
  // The information of 20 angles round the circle is 20.
  CHECK(std::sqrt(fit.variance) == Approx(kNoise / std::sqrt(20.0)).epsilon(0.3));
  CHECK((fit.offset - kOffset_ref).norm() < 4.0 * std::sqrt(fit.variance));
}

TEST_CASE("Angles that hardly vary determine no offset") {
  using test::Refused;
  CHECK_THROWS_MATCHES(fit_sweep_offset(sweeps(0.0, 10.0 * kDegree)), InputError,
                       Refused(Cause::kInsufficient, "sweep3"));
  CHECK_THROWS_MATCHES(fit_sweep_offset({}), InputError, Refused(Cause::kInsufficient, "0 usable"));
}

TEST_CASE("A sweep of two places, which fit whatever their noise, is refused") {
  const std::vector<SweepPoint> two{{0, 0.0, {0.1, 0.2}}, {0, kPi, {0.12, 0.26}}};
  CHECK_THROWS_MATCHES(fit_sweep_offset(two), InputError,
                       test::Refused(Cause::kInsufficient, "2 usable"));
}

}  // namespace planar
