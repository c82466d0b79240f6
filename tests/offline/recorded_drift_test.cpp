#include "planar_servo/offline/pairs/health_of_recording.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>

namespace planar {
namespace {

constexpr double kNoise_m = 2e-6;
/// Metres per second.
const Eigen::Vector2d kDrift(15e-9, -8e-9);

/// Twenty places in a row, so many times, 1.5 s each, under a camera that drifts.
std::vector<SeenPlace> rounds(int count, const Eigen::Vector2d& drift) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, kNoise_m);
  std::vector<SeenPlace> seen;
  for (int i = 0; i < 20 * count; ++i) {
    SeenPlace look;
    look.place.id = std::to_string(i);
    look.place.theta = Joints(0.1 * (i % 20), 0.5, 0.0);
    look.t_s = 1.5 * i;
    for (std::size_t k = 0; k < 2; ++k)
      look.place.lamps_B[k] = Eigen::Vector2d(0.01 * (i % 20), 0.04 * static_cast<double>(k)) +
                              look.t_s * drift + Eigen::Vector2d{noise(random), noise(random)};
    seen.push_back(look);
  }
  return seen;
}

TEST_CASE("Places that were visited again tell how the camera drifted") {
  const Eigen::Vector2d found = recorded_drift(rounds(10, kDrift)).m_per_s;
  CHECK((found - kDrift).norm() < 0.1 * kDrift.norm());
}

TEST_CASE("No drift is found without a second visit, nor in noise") {
  CHECK(recorded_drift(rounds(1, kDrift)).m_per_s.norm() == 0.0);
  CHECK(recorded_drift(rounds(10, {0.0, 0.0})).m_per_s.norm() == 0.0);
  CHECK(recorded_drift({}).m_per_s.norm() == 0.0);
}

TEST_CASE("Places that are kept are brought to the end of the recording") {
  const std::vector<SeenPlace> seen = rounds(10, kDrift);
  std::vector<HealthPlace> kept{seen[4].place};
  bring_to_end(seen, kept);
  const Eigen::Vector2d moved = kept[0].lamps_B[0] - seen[4].place.lamps_B[0];
  const double later_s = seen.back().t_s - seen[4].t_s;
  CHECK((moved - later_s * kDrift).norm() < 0.1 * later_s * kDrift.norm());
  CHECK(kept[0].sigma_m == seen[4].place.sigma_m);
}

TEST_CASE("A drift that is seen in the last third is a guess before, and the places say so") {
  const Eigen::Vector2d fast = 10.0 * kDrift;
  std::vector<SeenPlace> seen = rounds(10, fast);
  for (std::size_t i = 0; i < 120; ++i)
    seen[i].place.theta[1] = 0.6 + 1e-3 * static_cast<double>(i);
  std::vector<HealthPlace> kept{seen[4].place, seen[150].place};
  bring_to_end(seen, kept);
  CHECK(kept[0].sigma_m == Approx((180.0 - 6.0) * fast.norm()).epsilon(0.2));
  CHECK(kept[1].sigma_m == seen[150].place.sigma_m);
}

}  // namespace
}  // namespace planar
