#include "planar_servo/virtual_cell/virtual_lens.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "virtual_cell/sample_cell.h"

namespace planar {
namespace {

const AirTruth kAir{0.01, 1.0, 1250.0};
const Eigen::Vector2d kPlace_px(2000.0, 3000.0);

/// Returns the mean of products of two shifts, by their variance. Waves of many seeds stand for the
/// waves that there might be.
double correlation(double apart_s, double apart_px) {
  double sum = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const MovingAir air(kAir, seed);
    for (int i = 0; i < 40; ++i) {
      const double t_s = 7.3 * i;
      sum += air.shift_px(kPlace_px, t_s)
                 .dot(air.shift_px(kPlace_px + Eigen::Vector2d(apart_px, 0.0), t_s + apart_s));
      count += 2;
    }
  }
  return sum / count / (kAir.sigma_px * kAir.sigma_px);
}

constexpr double kChance = 0.12;  // three deviations of a correlation of 1600 looks with 40 seeds

}  // namespace

TEST_CASE("Air shifts points by the stated deviation, and forgets that in the stated time") {
  CHECK(std::abs(correlation(0.0, 0.0) - 1.0) < kChance);
  CHECK(std::abs(correlation(0.5, 0.0) - std::exp(-0.5)) < kChance);
  CHECK(std::abs(correlation(1.0, 0.0) - std::exp(-1.0)) < kChance);
  CHECK(std::abs(correlation(5.0, 0.0)) < kChance);
}

TEST_CASE("Air shifts near points alike, and far ones each in its own way") {
  CHECK(correlation(0.0, 80.0) > 1.0 - kChance);
  CHECK(std::abs(correlation(0.0, 1250.0) - std::exp(-0.5)) < 2.0 * kChance);
  CHECK(std::abs(correlation(0.0, 4000.0)) < 2.0 * kChance);
}

TEST_CASE("Air moves by seed and time alone, whatever was asked before") {
  const MovingAir air(kAir, 5), again(kAir, 5), other(kAir, 6);
  const Eigen::Vector2d late = air.shift_px(kPlace_px, 100.0);
  again.shift_px(kPlace_px, 3.0);
  again.shift_px(2.0 * kPlace_px, 250.0);
  CHECK(again.shift_px(kPlace_px, 100.0) == late);
  CHECK(other.shift_px(kPlace_px, 100.0) != late);
}

TEST_CASE("A lens behind air shifts every point, and one behind still air none") {
  CameraTruth camera = draw_truth(1).camera;
  const Eigen::Vector3d p_B(0.2, -0.1, 0.005);
  const Eigen::Vector2d still_px = *VirtualLens(camera, 5).project(p_B, 12.0);
  camera.air = kAir;
  const Eigen::Vector2d shift_px = *VirtualLens(camera, 5).project(p_B, 12.0) - still_px;
  CHECK((shift_px - MovingAir(kAir, 5).shift_px(still_px, 12.0)).norm() < 1e-9);
  camera.air->sigma_px = 0.0;
  CHECK(*VirtualLens(camera, 5).project(p_B, 12.0) == still_px);
}

}  // namespace planar
