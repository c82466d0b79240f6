#include "planar_servo/learn/error_map/maps/rbf_map.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/learn/error_map/fit/rbf_fit.h"
#include "support/error_fields.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kMapRounding = 1e-9;

MapSites two_sites(double distance) {
  MapSites sites;
  sites.positions.resize(2, 2);
  sites.positions << 0.0, distance, 0.0, 0.0;
  sites.errors.resize(2, 2);
  sites.errors << 1e-3, 0.0, 0.0, 2e-3;
  sites.counts.setOnes(2);
  sites.scatter.setZero(2);
  return sites;
}

TailBasis no_tail() {
  TailBasis tail;
  tail.degree = -1;
  return tail;
}

TEST_CASE("Without ridge the map passes through its samples, where it is certain") {
  const MapSites sites = merge_samples(
      test::measure(test::lens_field, test::ring_positions(60), test::kFieldNoise, 1));
  const auto fit = fit_rbf(sites, no_tail(), {KernelShape::kGaussian, 0.05, 0.0}, 0.0);
  for (Eigen::Index i = 0; i < sites.size(); ++i) {
    const ErrorPrediction at = fit.map.predict(sites.positions.col(i));
    CHECK((at.error - sites.errors.col(i)).norm() < kMapRounding * sites.errors.norm());
    CHECK(at.sigma < 1e-6 * fit.map.parameters().signal_sigma);
  }
}

TEST_CASE("Two samples, a width and a ridge give the textbook weights and variance") {
  const double width = 0.1;
  const double ridge = 0.5;
  const MapSites sites = two_sites(0.1);
  const auto fit = fit_rbf(sites, no_tail(), {KernelShape::kGaussian, width}, ridge);
  const double phi = std::exp(-0.5);
  const double diagonal = 1.0 + ridge;
  const double determinant = diagonal * diagonal - phi * phi;
  const auto& parameters = fit.map.parameters();
  CHECK(parameters.weights(0, 0) == Approx(1e-3 * diagonal / determinant));
  CHECK(parameters.weights(0, 1) == Approx(-1e-3 * phi / determinant));
  CHECK(parameters.weights(1, 1) == Approx(2e-3 * diagonal / determinant));
  const double signal2 = (1e-6 + 4e-6) * diagonal / determinant / (2.0 * 2.0);
  CHECK(parameters.signal_sigma == Approx(std::sqrt(signal2)));
  CHECK(fit.map.noise_sigma() == Approx(std::sqrt(ridge * signal2)));
  const double form = (diagonal - 2.0 * phi * phi + diagonal * phi * phi) / determinant;
  CHECK(fit.map.predict({0.0, 0.0}).sigma == Approx(std::sqrt(signal2 * (1.0 - form))));
}

TEST_CASE(
    "Far from every sample the map without a tail says nothing, and says how little it knows") {
  const auto fit = fit_rbf(two_sites(0.1), no_tail(), {KernelShape::kGaussian, 0.1, 0.0}, 0.01);
  const ErrorPrediction far = fit.map.predict({50.0, 0.0});
  CHECK(far.error.norm() == 0.0);
  CHECK(far.sigma == fit.map.parameters().signal_sigma);
  CHECK_FALSE(far.inside);
}

TEST_CASE("A linear field is the tail's alone") {
  const auto linear = [](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(1e-3 + 2e-3 * p.x(), 3e-3 * p.y() - 1e-3 * p.x());
  };
  const MapSites sites =
      merge_samples(test::measure(linear, test::random_positions(50, 2), 0.0, 1));
  const auto fit =
      fit_rbf(sites, tail_for(sites.positions), {KernelShape::kGaussian, 0.1, 0.0}, 1e-3);
  CHECK(fit.map.parameters().weights.norm() < kMapRounding);
  const Eigen::Vector2d outside(0.9, -0.9);
  CHECK((fit.map.predict(outside).error - linear(outside)).norm() < kMapRounding);
}

TEST_CASE("A site of several samples counts like these samples") {
  MapSites merged = two_sites(0.1);
  merged.counts << 4.0, 1.0;
  const auto fit = fit_rbf(merged, no_tail(), {KernelShape::kGaussian, 0.1, 0.0}, 0.4);
  const double noise_of_four = 0.4 / 4.0;
  const double phi = std::exp(-0.5);
  const double determinant = (1.0 + noise_of_four) * 1.4 - phi * phi;
  CHECK(fit.map.parameters().weights(0, 0) == Approx(1e-3 * 1.4 / determinant));
}

TEST_CASE("A width that joins all samples is refused without a ridge, with figures and a remedy") {
  const MapSites sites =
      merge_samples(test::measure(test::lens_field, test::ring_positions(100), 0.0, 1));
  CHECK_THROWS_AS(fit_rbf(sites, no_tail(), {KernelShape::kGaussian, 1.0, 0.0}, 0.0), WorkError);
  CHECK_THROWS_MATCHES(fit_rbf(sites, no_tail(), {KernelShape::kGaussian, 1.0, 0.0}, 0.0),
                       WorkError,
                       Refused(Cause::kInsufficient, "100 samples with a width of 1000 mm"));
}

TEST_CASE("A map made of a map's parameters predicts the same, bit for bit") {
  const MapSites sites = merge_samples(
      test::measure(test::glow_field, test::random_positions(80, 3), test::kFieldNoise, 1));
  const auto shape = GENERATE(KernelShape::kGaussian, KernelShape::kMultiquadric);
  const auto fit = fit_rbf(sites, tail_for(sites.positions, 2), {shape, 0.15, 2.0}, 1e-3);
  const RbfMap copy(fit.map.parameters());
  for (const Eigen::Vector2d& p : test::random_positions(50, 4)) {
    CHECK(copy.predict(p).error == fit.map.predict(p).error);
    CHECK(copy.predict(p).sigma == fit.map.predict(p).sigma);
    CHECK(copy.predict_error(p) == fit.map.predict(p).error);
  }
}

}  // namespace
}  // namespace planar
