#include "planar_servo/geometry/tool/tips.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "calibration/synthetic_cell.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kRoundTrip = 1e-10;  // m: the lens is inverted iteratively
constexpr double kSeparation = 0.04;

TEST_CASE("The end point seen through its lamps is the one they were placed from") {
  const test::SyntheticCell cell;
  ToolOffsets tool;
  tool.p_TP = {0.001, -0.002};
  const TipPose tip{{0.2, -0.1}, 2.5};
  const auto lamps = lamps_from_tip(cell.workplane(), tool, kSeparation, tip);
  REQUIRE(lamps.has_value());
  const Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity() * 1e-4;
  const auto seen =
      tip_from_lamps(cell.workplane(), tool, {0.0, 1, *lamps, {covariance, covariance}});
  REQUIRE(seen.has_value());
  CHECK((seen->tip.p - tip.p).norm() < kRoundTrip);
  CHECK(seen->tip.phi == Approx(tip.phi).margin(1e-8));
  // Two lamps of 0.01 px each: their mean is 1/sqrt 2 of that, times the size of a pixel.
  const double pixel = kSeparation / ((*lamps)[1] - (*lamps)[0]).norm();
  CHECK(std::sqrt(0.5 * seen->covariance.trace()) ==
        Approx(0.01 / std::sqrt(2.0) * pixel).epsilon(0.05));
}

TEST_CASE("The end point's and the direction's uncertainty are those of shaken lamps") {
  constexpr int kRuns = 4000;
  constexpr double kScatter = 0.1;  // a variance of 4000 runs is good to 2 %, one sigma
  const test::SyntheticCell cell;
  ToolOffsets tool;
  tool.p_TP = {0.03, 0.05};  // so far off that a turn moves the end point
  const auto lamps = lamps_from_tip(cell.workplane(), tool, kSeparation, {{0.2, -0.1}, 0.7});
  REQUIRE(lamps.has_value());
  Eigen::Matrix2d root_first, root_second;
  root_first << 0.02, 0.0, 0.005, 0.01;
  root_second << 0.01, 0.0, 0.0, 0.03;
  const Eigen::Matrix2d first = root_first * root_first.transpose();
  const Eigen::Matrix2d second = root_second * root_second.transpose();
  const auto seen = tip_from_lamps(cell.workplane(), tool, {0.0, 1, *lamps, {first, second}});
  REQUIRE(seen.has_value());
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  double scatter_phi = 0.0;
  for (int i = 0; i < kRuns; ++i) {
    auto shaken = *lamps;
    shaken[0] += root_first * Eigen::Vector2d{normal(random), normal(random)};
    shaken[1] += root_second * Eigen::Vector2d{normal(random), normal(random)};
    const auto run = tip_from_lamps(cell.workplane(), tool, {0.0, 1, shaken});
    const Eigen::Vector2d e = run->tip.p - seen->tip.p;
    scatter += e * e.transpose() / kRuns;
    scatter_phi += std::pow(run->tip.phi - seen->tip.phi, 2) / kRuns;
  }
  CHECK((scatter - seen->covariance).norm() < kScatter * seen->covariance.norm());
  CHECK(scatter_phi == Approx(seen->sigma_phi * seen->sigma_phi).epsilon(kScatter));
}

TEST_CASE("Frames of one rest lessen their noise, not the shift that they share") {
  constexpr int kRuns = 4000, kFrames = 5;
  constexpr double kScatter = 0.1, kNoise_px = 0.02, kShift_px = 0.01;
  const test::SyntheticCell cell;
  const auto lamps = lamps_from_tip(cell.workplane(), {}, kSeparation, {{0.2, -0.1}, 0.7}).value();
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  const auto shaken = [&](double sigma) {
    return Eigen::Vector2d{sigma * normal(random), sigma * normal(random)};
  };
  const Eigen::Matrix2d noise = kNoise_px * kNoise_px * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d common = kShift_px * kShift_px * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d p = tip_from_lamps(cell.workplane(), {}, {0.0, 1, lamps})->tip.p;
  double scatter = 0.0;
  VisionTip seen;
  for (int i = 0; i < kRuns; ++i) {
    const Eigen::Vector2d shift = shaken(kShift_px);
    std::vector<Observation> frames;
    frames.reserve(kFrames);
    for (int k = 0; k < kFrames; ++k)
      frames.push_back(
          {0.1 * k,
           1,
           {lamps[0] + shift + shaken(kNoise_px), lamps[1] + shift + shaken(kNoise_px)},
           {noise, noise},
           common});
    const Observation mean = mean_of(frames);
    CHECK((mean.frames == kFrames && mean.t_s == 0.0));
    seen = tip_from_lamps(cell.workplane(), {}, mean).value();
    scatter += 0.5 * (seen.tip.p - p).squaredNorm() / kRuns;
  }
  CHECK(std::sqrt(scatter) == Approx(per_axis(seen.covariance)).epsilon(kScatter));
  CHECK(per_axis(seen.covariance) / per_axis(seen.noise) ==
        Approx(std::sqrt(1.0 + 2.0 * kFrames * common(0, 0) / noise(0, 0))).epsilon(1e-3));
}

TEST_CASE("The eccentricity of the lamps' discs is taken off exactly") {
  const test::SyntheticCell cell;
  const std::array<double, 2> diameters{0.03, 0.06};
  const TipPose tip{{0.2, -0.1}, 2.5};
  const auto lamps = lamps_from_tip(cell.workplane(), {}, kSeparation, tip);
  REQUIRE(lamps.has_value());
  const auto shifts = lamp_eccentricities_px(cell.workplane(), *lamps, diameters);
  CHECK(shifts[1].norm() == Approx(4.0 * shifts[0].norm()).epsilon(0.1));  // radius squared
  // From the discs' places instead of the lamps', the shift is the same but for its own change.
  const auto seen_shifts = lamp_eccentricities_px(
      cell.workplane(), {(*lamps)[0] + shifts[0], (*lamps)[1] + shifts[1]}, diameters);
  for (const std::size_t k : {0u, 1u}) CHECK((seen_shifts[k] - shifts[k]).norm() < 1e-4);
  CHECK(lamp_eccentricities_px(cell.workplane(), *lamps, {0.0, 0.0})[0].isZero());
}

TEST_CASE("Swapped lamps turn the tool by half a turn") {
  const test::SyntheticCell cell;
  const ToolOffsets tool;
  const auto lamps = lamps_from_tip(cell.workplane(), tool, kSeparation, {{0.1, 0.3}, 0.5});
  REQUIRE(lamps.has_value());
  const auto seen = tip_from_lamps(cell.workplane(), tool, {0.0, 1, {(*lamps)[1], (*lamps)[0]}});
  REQUIRE(seen.has_value());
  CHECK(seen->tip.phi == Approx(0.5 - kPi));
  CHECK((seen->tip.p - Eigen::Vector2d(0.1, 0.3)).norm() < kRoundTrip);
}

}  // namespace
}  // namespace planar
