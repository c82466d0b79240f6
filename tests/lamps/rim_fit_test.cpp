#include "planar_servo/lamps/rim/rim_fit.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "support/rendered_lamp.h"

namespace planar {
namespace {

constexpr int kThreshold = 60;
constexpr double kReach_px = 6.0;
const Eigen::Vector2d kCenter(64.2, 63.9);

cv::Mat lamp_scene(double diameter_px = 40.0, double blur_px = 0.85) {
  cv::Mat scene = test::background({128, 128});
  test::add_lamp(scene, {kCenter, diameter_px, 1.0, 0.0, 180.0, blur_px});
  return scene;
}

std::optional<RimFit> fit(const cv::Mat& scene, unsigned seed) {
  std::mt19937 random(seed);
  const cv::Mat image = test::expose(scene, random);
  const Blob blob = describe_blob(image, cv::boundingRect(image > kThreshold), kThreshold);
  return fit_rim(image, blob, kReach_px);
}

// Six times the error of a clean lamp: what a defect may add.
constexpr double kDefect_px = 0.02;

TEST_CASE("fit_rim finds the middle of a disc whose light leans to one side") {
  cv::Mat scene = lamp_scene();
  for (int u = 0; u < scene.cols; ++u) {
    scene.col(u) = 12.0 + (scene.col(u) - 12.0) * (0.8 + 0.015 * (u - kCenter.x()));
  }
  const auto rim = fit(scene, 1);
  REQUIRE(rim);
  CHECK((rim->center - kCenter).norm() < kDefect_px);
}

TEST_CASE("fit_rim finds the middle of a disc with a glow on one side") {
  constexpr double kSharp_px = 0.1, kBlur_px = 0.85;
  cv::Mat scene = lamp_scene(40.0, kSharp_px);
  for (int v = 0; v < scene.rows; ++v) {
    for (int u = 0; u < scene.cols; ++u) {
      const Eigen::Vector2d d = Eigen::Vector2d(u, v) - kCenter;
      if (d.norm() < 20.0 || d.x() < 0.0) continue;
      const double glow = 40.0 * d.x() / d.norm() * std::exp(-(d.norm() - 20.0) / 6.0);
      scene.at<float>(v, u) += static_cast<float>(glow);
    }
  }
  cv::GaussianBlur(scene, scene, cv::Size(), kBlur_px);
  const auto rim = fit(scene, 2);
  REQUIRE(rim);
  CHECK((rim->center - kCenter).norm() < 2.0 * kDefect_px);
}

TEST_CASE("fit_rim leaves out a dark speck on the rim and a hair across it") {
  cv::Mat scene = lamp_scene();
  cv::circle(scene, {83, 70}, 3, cv::Scalar(12.0), cv::FILLED);
  cv::line(scene, {30, 20}, {60, 60}, cv::Scalar(12.0), 2);
  cv::GaussianBlur(scene, scene, cv::Size(), 0.6);
  const auto rim = fit(scene, 3);
  REQUIRE(rim);
  CHECK((rim->center - kCenter).norm() < kDefect_px);
  CHECK(rim->largest_gap > 5.0 * kDegree);
  CHECK(rim->largest_gap < 60.0 * kDegree);
}

/// A lamp whose rim is bent all round, by a share of the radius in every harmonic from 2 to 9, and
/// turned by an angle; whose light falls to a third from one side to the other; and of which a
/// straight cut at this share of the radius takes the brightest piece.
cv::Mat bent_scene(double bend = 0.025, double turn = 0.0, double cut = 2.0) {
  constexpr double kRadius_px = 17.0;
  constexpr int kFine = 8;
  cv::Mat fine = test::background({128 * kFine, 128 * kFine});
  for (int v = 0; v < fine.rows; ++v) {
    for (int u = 0; u < fine.cols; ++u) {
      const Eigen::Vector2d d = (Eigen::Vector2d(u, v).array() + 0.5).matrix() / kFine - kCenter -
                                Eigen::Vector2d(.5, .5);
      if (d.norm() > 1.5 * kRadius_px || d.x() > cut * kRadius_px) continue;
      double radius = 1.0;
      for (int order = 2; order <= 9; ++order)
        radius += bend * std::sin(order * (std::atan2(d.y(), d.x()) - turn) + order * order);
      if (d.norm() < kRadius_px * radius)
        fine.at<float>(v, u) += static_cast<float>(100.0 * (1.0 + 0.5 * d.x() / kRadius_px));
    }
  }
  cv::Mat scene;
  cv::resize(fine, scene, {128, 128}, 0.0, 0.0, cv::INTER_AREA);
  cv::GaussianBlur(scene, scene, cv::Size(), 0.75);
  return scene;
}

TEST_CASE(
    "fit_rim mostly follows a rim that is bent all round and unevenly lit, and as well as it "
    "says") {
  const cv::Mat scene = bent_scene();
  constexpr unsigned kSeeds = 40;
  std::vector<Eigen::Vector2d> centers;
  double stated = 0.0;
  Eigen::Vector2d mean(0.0, 0.0);
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const auto rim = fit(scene, seed);
    if (!rim || rim->largest_gap > 30.0 * kDegree) continue;
    stated += rim->center_covariance.trace();
    mean += rim->center;
    centers.push_back(rim->center);
  }
  const auto n = static_cast<double>(centers.size());
  REQUIRE(n >= 0.9 * kSeeds);
  double variance = 0.0;
  for (const Eigen::Vector2d& center : centers) variance += (center - mean / n).squaredNorm();
  CHECK(variance / (n - 1.0) < 2.0 * stated / n);
  CHECK(variance / (n - 1.0) > 0.25 * stated / n);
}

TEST_CASE("fit_rim says how badly it knows a rim that is bent, unevenly lit and cut") {
  constexpr unsigned kLamps = 60;
  constexpr double kThreeSigmas = 9.0;
  int measured = 0, farther = 0;
  for (unsigned i = 0; i < kLamps; ++i) {
    const auto rim = fit(bent_scene(0.0125, 2.0 * kPi * i / kLamps, 0.8), i);
    if (!rim || rim->largest_gap > 100.0 * kDegree) continue;
    const Eigen::Vector2d error = rim->center - kCenter;
    ++measured;
    if (0.5 * error.dot(rim->center_covariance.inverse() * error) > kThreeSigmas) ++farther;
  }
  CHECK(measured > 30);
  CHECK(farther <= 3);  // one in 20
}

TEST_CASE("fit_rim measures a lamp whose rim leaves its centre in doubt, and states the doubt") {
  constexpr unsigned kLamps = 60;
  constexpr double kMostNoise_px = 0.25;
  int doubted = 0;
  for (unsigned i = 0; i < kLamps; ++i) {
    const auto rim = fit(bent_scene(0.0125, 2.0 * kPi * i / kLamps, 0.8), i);
    if (!rim || rim->center_covariance.trace() < 2.0 * kMostNoise_px * kMostNoise_px) continue;
    const Eigen::Vector2d error = rim->center - kCenter;
    CHECK(error.dot(rim->center_covariance.inverse() * error) < 9.0);
    ++doubted;
  }
  CHECK(doubted > 0);
}

TEST_CASE("fit_rim tells how wide a straight cut is") {
  cv::Mat scene = lamp_scene();
  scene(cv::Rect(80, 0, 48, 128)) = 12.0;
  cv::GaussianBlur(scene, scene, cv::Size(), 0.6);
  const auto rim = fit(scene, 4);
  REQUIRE(rim);
  CHECK((rim->center - kCenter).norm() < 2.0 * kDefect_px);
  // The chord at 79.5 - 64.2 of 20 px spans 80 degrees; the blur reaches 2 to 3 px beyond its ends.
  CHECK(rim->largest_gap == Approx(95.0 * kDegree).margin(10.0 * kDegree));
}

TEST_CASE("fit_rim measures lamps from 12 to 120 px") {
  for (const double diameter : {12.0, 30.0, 70.0, 100.0}) {
    const auto rim = fit(lamp_scene(diameter), 5);
    REQUIRE(rim);
    CHECK((rim->center - kCenter).norm() < kDefect_px);
    CHECK(rim->diameter == Approx(diameter).margin(0.1));
  }
}

TEST_CASE("fit_rim is empty where there is no disc") {
  std::mt19937 random(7);
  cv::Mat square = test::background({128, 128});
  square(cv::Rect(40, 40, 40, 60)) = 200.0;
  const auto rim = fit(square, 6);
  CHECK((!rim || rim->largest_gap > 100.0 * kDegree || rim->center_covariance.trace() > 0.01));

  Blob nothing;
  nothing.uv_px = kCenter;
  nothing.area_px2 = 1200.0;
  nothing.second_moments_px2 = 100.0 * Eigen::Matrix2d::Identity();
  nothing.box_px = {44, 44, 40, 40};
  nothing.level = 100.0;
  nothing.background = 12.0;
  const cv::Mat dark = test::expose(test::background({128, 128}), random);
  CHECK_FALSE(fit_rim(dark, nothing, kReach_px));
}

}  // namespace
}  // namespace planar
