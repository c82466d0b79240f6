#include "planar_servo/lamps/rim/outline.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr int kCount = 128;
constexpr double kNoise_px = 0.02;
constexpr Agreement kAgreement{kNoise_px, 0.9};

Normals normals_of_circle() {
  Outline circle;
  circle.axes *= 20.0;
  Normals normals;
  normals.spread(circle, kCount);
  return normals;
}

PerNormal noise(std::mt19937& random) {
  std::normal_distribution<double> normal(0.0, kNoise_px);
  PerNormal values(kCount);
  for (double& value : values) value = normal(random);
  return values;
}

PerNormal informations(const NormalFlags& use) {
  return use.cast<double>().matrix() / (kNoise_px * kNoise_px);
}

const NormalFlags kAll = NormalFlags::Constant(kCount, true);

TEST_CASE("fit_outline gives back exact offsets, of the shape and of the waves") {
  const Normals normals = normals_of_circle();
  Outline::Terms truth = Outline::Terms::Zero();
  truth.head<5>() << 0.3, -0.2, 0.1, 0.05, -0.1;
  const OutlineFit plain =
      fit_outline(normals, normals.move.transpose() * truth, informations(kAll));
  CHECK_FALSE(plain.has_waves);
  CHECK((plain.terms - truth).norm() < 1e-9);

  truth.tail<4>() << 0.4, -0.3, 0.2, 0.5;
  const OutlineFit wavy =
      fit_outline(normals, normals.move.transpose() * truth, informations(kAll));
  CHECK(wavy.has_waves);
  // The prior draws the waves towards zero by less than their noise.
  CHECK((wavy.terms - truth).lpNorm<Eigen::Infinity>() < 0.1 * kNoise_px);
}

TEST_CASE("fit_outline takes waves for noise alone in few rims of many, and states its errors") {
  std::mt19937 random(1);
  const Normals normals = normals_of_circle();
  constexpr int kRuns = 400;
  int wavy = 0;
  double standardised = 0.0;
  for (int i = 0; i < kRuns; ++i) {
    const OutlineFit fit = fit_outline(normals, noise(random), informations(kAll));
    wavy += fit.has_waves ? 1 : 0;
    standardised += 0.5 * (fit.terms[0] * fit.terms[0] / fit.covariance(0, 0) +
                           fit.terms[1] * fit.terms[1] / fit.covariance(1, 1));
  }
  CHECK(wavy < kRuns / 50);
  // 800 squares of standard normal numbers: their mean is 1 within 4 x sqrt(2 / 800).
  CHECK(standardised / kRuns == Approx(1.0).margin(0.2));
}

/// A straight cut at 0.8 of the radius, about normal `middle`.
PerNormal cut(const Normals& normals, int middle) {
  PerNormal offsets = PerNormal::Zero(kCount);
  for (int k = 0; k < kCount; ++k) {
    const double c = normals.direction.col(k).dot(normals.direction.col(middle));
    if (c > 0.8) offsets[k] = 20.0 * (0.8 / c - 1.0);
  }
  return offsets;
}

TEST_CASE("fit_without_arc and agreeing leave out a cut, and little more, wherever it is") {
  std::mt19937 random(2);
  const Normals normals = normals_of_circle();
  constexpr double kWave_px2 = 0.01;
  for (int middle = 0; middle < kCount; middle += 9) {
    const PerNormal truth = cut(normals, middle), offsets = truth + noise(random);
    const ArcFit arc = fit_without_arc(normals, offsets, informations(kAll), kWave_px2);
    const NormalFlags rough = agreeing(normals, offsets, arc.fit, kAgreement, kAll, arc.use);
    const OutlineFit fit = fit_outline(normals, offsets, informations(rough));
    const NormalFlags use = agreeing(normals, offsets, fit, kAgreement, kAll, rough);
    CHECK((truth.array().abs() > 0.3 && use).count() == 0);
    const auto untouched = (truth.array() == 0.0).count();
    CHECK(static_cast<double>(use.count()) > 0.9 * static_cast<double>(untouched));
    CHECK(fit.terms.head<2>().norm() <
          4.0 * std::sqrt(fit.covariance.topLeftCorner<2, 2>().trace()));
  }
}

TEST_CASE("agreeing leaves out what cannot be read, and its neighbours") {
  const Normals normals = normals_of_circle();
  NormalFlags readable = kAll;
  readable[10] = false;
  const NormalFlags use =
      agreeing(normals, PerNormal::Zero(kCount), OutlineFit(), kAgreement, readable, kAll);
  CHECK((!use).count() == 5);
  CHECK_FALSE(use[8]);
  CHECK_FALSE(use[12]);
}

}  // namespace
}  // namespace planar
