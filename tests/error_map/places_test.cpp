#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "support/error_fields.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

constexpr double kPlaceSigma = 0.020e-3;
constexpr double kReadingSigma = 0.005e-3;
constexpr std::size_t kPerPlace = 4;
constexpr double kPlaceWidth = 2e-3;

/// Readings at random places, `kPerPlace` at each, wrong by an error that they share and one of
/// their own.
std::vector<ErrorSample> readings_at_places(int places, double place_sigma, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> aside(-0.5 * kPlaceWidth, 0.5 * kPlaceWidth);
  std::vector<ErrorSample> samples;
  for (const Eigen::Vector2d& place : test::random_positions(places, seed)) {
    const Eigen::Vector2d shared = place_sigma * Eigen::Vector2d{normal(random), normal(random)};
    for (std::size_t i = 0; i < kPerPlace; ++i) {
      const Eigen::Vector2d p = place + Eigen::Vector2d{aside(random), aside(random)};
      const Eigen::Vector2d own = kReadingSigma * Eigen::Vector2d{normal(random), normal(random)};
      samples.push_back(
          {std::to_string(samples.size()), p, test::lens_field(p) + shared + own, 0.0, {}, {}});
    }
  }
  return samples;
}

std::vector<ErrorSample> named(std::vector<ErrorSample> samples, std::size_t per_place) {
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i].place = "p" + std::to_string(i / per_place);
  return samples;
}

double rms_of_misses(const ErrorMap& map) {
  std::vector<double> misses;
  for (const Eigen::Vector2d& p : test::random_positions(1000, 100))
    misses.push_back((predict_error(map, p) - test::lens_field(p)).norm());
  return rms(misses);
}

TEST_CASE("Readings of a place leave together, whether it is named or found") {
  const auto samples = readings_at_places(100, kPlaceSigma, 1);
  const MapResult apart = fit_error_map({named(samples, 1)});
  const MapResult by_name = fit_error_map({named(samples, kPerPlace)});
  const MapResult found = fit_error_map({samples});
  CHECK(by_name.places == PlaceSource::kNamed);
  CHECK(found.places == PlaceSource::kFound);
  CHECK(apart.n_places == 400);
  CHECK(by_name.n_places == 100);
  CHECK(found.n_places == Approx(100).margin(3));  // some lie side by side
  const double unseen_place = std::hypot(kPlaceSigma, kReadingSigma) * std::sqrt(2.0);
  for (const MapResult* together : {&by_name, &found}) {
    const double missed = rms_of_misses(together->map);
    CHECK(together->n_used == 400);
    CHECK(missed < 0.7 * rms_of_misses(apart.map));
    CHECK(together->loo_rms == Approx(std::hypot(missed, unseen_place)).epsilon(0.2));
    CHECK(together->worth_using);
  }
  CHECK(apart.loo_rms < 0.5 * by_name.loo_rms);
}

TEST_CASE("The noise of a place and that of a reading are told apart") {
  for (const double place_sigma : {0.0, 0.3 * kReadingSigma, kPlaceSigma}) {
    const auto samples = readings_at_places(150, place_sigma, 2);
    const MapResult result = fit_error_map({named(samples, kPerPlace)});
    CAPTURE(place_sigma);
    CHECK(result.place_sigma() == Approx(place_sigma).epsilon(0.2).margin(0.3 * kReadingSigma));
    CHECK(result.reading_sigma() == Approx(kReadingSigma).epsilon(0.1));
    CHECK(result.noise_sigma == Approx(std::hypot(place_sigma, kReadingSigma)).epsilon(0.15));
  }
}

TEST_CASE("The stated standard deviation holds for readings that share places") {
  int covered = 0;
  int count = 0;
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const MapResult result = fit_error_map({readings_at_places(100, kPlaceSigma, seed)});
    for (const Eigen::Vector2d& p : test::random_positions(1000, 100)) {
      const ErrorPrediction at = predict(result.map, p);
      covered += static_cast<int>(
          ((at.error - test::lens_field(p)).array().abs() <= 1.96 * at.sigma).count());
      count += 2;
    }
  }
  CHECK(covered / static_cast<double>(count) == Approx(0.95).margin(0.04));
}

TEST_CASE("Places with few readings weigh nearly as much as those with many") {
  const auto all = readings_at_places(100, kPlaceSigma, 3);
  std::vector<ErrorSample> some;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i % kPerPlace == 0 || i < all.size() / 2) some.push_back(named(all, kPerPlace)[i]);
  const MapResult result = fit_error_map({some});
  const Eigen::VectorXd& weights = std::get<RbfMap>(result.map).parameters().counts;
  CHECK(weights.minCoeff() == Approx(1.0));
  CHECK(weights.maxCoeff() < 1.2);
  CHECK(result.place_sigma() == Approx(kPlaceSigma).epsilon(0.2));
}

TEST_CASE("Where every reading has a place of its own, naming it changes nothing") {
  const auto samples =
      test::measure(test::glow_field, test::random_positions(120, 4), test::kFieldNoise, 4);
  const MapResult without = fit_error_map({samples});
  const MapResult with = fit_error_map({named(samples, 1)});
  CHECK(std::get<RbfMap>(with.map).parameters().weights ==
        std::get<RbfMap>(without.map).parameters().weights);
  CHECK(with.loo_rms == without.loo_rms);
  CHECK(with.noise_sigma == without.noise_sigma);
  CHECK(with.blocked.value == without.blocked.value);
  CHECK(std::isnan(with.place_share));
}

TEST_CASE("Readings in groups that share no error are fitted as if they lay apart") {
  const auto samples = readings_at_places(100, 0.0, 5);
  const MapResult result = fit_error_map({samples});
  CHECK(result.places == PlaceSource::kPositions);
  CHECK(result.n_places == 400);
}

TEST_CASE("Beyond a thousand places their readings leave together, too") {
  const auto samples = named(readings_at_places(1100, kPlaceSigma, 6), kPerPlace);
  const MapResult result = fit_error_map({samples});
  CHECK(kind_of(result.map) == MapKind::kSparseGaussianRbf);
  CHECK(result.n_places == Approx(1100).margin(2));  // a chance outlier or two
  CHECK(result.place_sigma() == Approx(kPlaceSigma).epsilon(0.1));
  CHECK(result.reading_sigma() == Approx(kReadingSigma).epsilon(0.1));
}

TEST_CASE("A reading that disagrees with the others of its place is left out alone") {
  auto samples = named(readings_at_places(100, kPlaceSigma, 7), kPerPlace);
  samples[41].error.x() += 0.1e-3;
  const MapResult result = fit_error_map({samples});
  REQUIRE(result.rejected.size() == 1);
  CHECK(result.rejected[0].id == "41");
  CHECK_THAT(result.rejected[0].reason, Contains("from the other pairs of its place"));
  CHECK(result.n_used == 399);
  CHECK(result.reading_sigma() == Approx(kReadingSigma).epsilon(0.1));
}

TEST_CASE("A whole place that disagrees with the others is left out") {
  auto samples = named(readings_at_places(100, kPlaceSigma, 8), kPerPlace);
  for (std::size_t i = 40; i < 44; ++i) samples[i].error.y() += 0.4e-3;
  const MapResult result = fit_error_map({samples});
  REQUIRE(result.rejected.size() == kPerPlace);
  CHECK(result.rejected[0].id == "40");
  CHECK(result.n_places == 99);
}

TEST_CASE("Errors that only the readings of a place share are not sold as a gain") {
  auto samples = readings_at_places(60, kPlaceSigma, 9);
  for (ErrorSample& sample : samples) sample.error -= test::lens_field(sample.p_vision);
  CHECK(fit_error_map({named(samples, 1)}).gain() > 0.5);
  CHECK_FALSE(fit_error_map({named(samples, kPerPlace)}).worth_using);
  CHECK_FALSE(fit_error_map({samples}).worth_using);
}

TEST_CASE("Words that are no places are refused") {
  auto samples = named(readings_at_places(20, 0.0, 1), kPerPlace);
  samples[9].place = samples[0].place;
  CHECK_THROWS_AS(fit_error_map({samples}), InputError);
  CHECK_THROWS_MATCHES(fit_error_map({samples}), InputError,
                       Refused(Cause::kContradiction, "place 'p0': its 5 pairs"));
  for (ErrorSample& sample : samples) sample.place = "hall";
  CHECK_THROWS_MATCHES(fit_error_map({samples}), InputError,
                       Refused(Cause::kInsufficient, "80 pairs have 1 "));
}

}  // namespace
}  // namespace planar
