#include "planar_servo/learn/error_map/fit_error_map.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "support/error_fields.h"
#include "support/refused.h"
#include "support/shared_data.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

struct Score {
  double error_over_noise{0.0};  // rms per axis against the noise-free field, over the noise
  double coverage{0.0};          // share of components within 1.96 stated standard deviations
};

Score score(const ErrorMap& map, const test::ErrorField& field) {
  std::vector<double> misses;
  int covered = 0;
  for (const Eigen::Vector2d& p : test::random_positions(1000, 100)) {
    const ErrorPrediction prediction = predict(map, p);
    for (const double miss : Eigen::Vector2d(prediction.error - field(p))) {
      misses.push_back(miss);
      if (std::abs(miss) <= 1.96 * prediction.sigma) ++covered;
    }
  }
  return {rms(misses) / test::kFieldNoise, covered / static_cast<double>(misses.size())};
}

struct Field {
  const char* name;
  test::ErrorField field;
  double on_rings;  // what one width and a ridge by leave-one-out reach elsewhere on 200 samples
  double at_random;
};

std::vector<Field> fields() {
  return {{"lens", test::lens_field, 0.35, 0.39},
          {"glow", test::glow_field, 0.83, 1.20},
          {"bumpy", test::bumpy_field, 0.86, 1.54}};
}

// E/sigma moves by about 10 % from one noise draw to the next, and layouts differ more.
constexpr double kDrawToDraw = 1.25;

TEST_CASE("On made-up fields the tuned map is as near to the truth as this kind of map comes") {
  for (const Field& field : fields()) {
    std::vector<double> rings;
    std::vector<double> random;
    for (std::uint32_t seed = 1; seed <= 5; ++seed) {
      const auto fit_score = [&](const std::vector<Eigen::Vector2d>& positions) {
        const auto samples = test::measure(field.field, positions, test::kFieldNoise, seed);
        return score(fit_error_map({samples}).map, field.field).error_over_noise;
      };
      rings.push_back(fit_score(test::ring_positions(200)));
      random.push_back(fit_score(test::random_positions(200, seed)));
    }
    INFO(field.name);
    CHECK(median(rings) < kDrawToDraw * field.on_rings);
    CHECK(median(random) < kDrawToDraw * field.at_random);
  }
}

TEST_CASE("The stated standard deviation covers the truth about as often as it says") {
  double coverage = 0.0;
  int draws = 0;
  for (const Field& field : fields()) {
    for (std::uint32_t seed = 1; seed <= 5; ++seed, ++draws) {
      const auto samples = test::measure(field.field, test::random_positions(200, seed),
                                         test::kFieldNoise, seed + 10);
      coverage += score(fit_error_map({samples}).map, field.field).coverage;
    }
  }
  CHECK(coverage / draws > 0.92);
  CHECK(coverage / draws < 0.98);
}

TEST_CASE("The tuned map is beside the paper's baselines what it claims to be") {
  const auto samples =
      test::measure(test::glow_field, test::ring_positions(200), test::kFieldNoise, 1);
  const MapResult rbf = fit_error_map({samples, MapMethod::kRbf});
  const MapResult idw = fit_error_map({samples, MapMethod::kIdw});
  const MapResult hand = fit_error_map({samples, MapMethod::kHandWidth, 0.048});
  CHECK(kind_of(rbf.map) == MapKind::kGaussianRbf);
  CHECK(kind_of(idw.map) == MapKind::kIdw);
  CHECK(kind_of(hand.map) == MapKind::kGaussianRbf);
  CHECK(rbf.loo_rms < hand.loo_rms);
  CHECK(hand.loo_rms < idw.loo_rms);
  CHECK(rbf.idw_loo_rms == idw.loo_rms);
  CHECK(rbf.raw_rms == idw.raw_rms);
  CHECK(rbf.worth_using);
  CHECK(rbf.gain() > 0.9);
  CHECK(rbf.noise_sigma == Approx(test::kFieldNoise).epsilon(0.2));
  CHECK(std::isnan(idw.noise_sigma));
  CHECK(std::isnan(hand.noise_sigma));
}

// The glow's knee is sharper than one width can follow: a sample or two there may look wrong.
constexpr std::size_t kGoodOnesLost = 2;

TEST_CASE("Outliers are named with their residual and do not bend the map") {
  auto samples = test::measure(test::glow_field, test::ring_positions(200), test::kFieldNoise, 1);
  const double clean = score(fit_error_map({samples}).map, test::glow_field).error_over_noise;
  const std::set<std::string> bad{"140", "199", "20", "80"};
  for (const std::string& id : bad) samples[std::stoul(id)].error.x() += 0.5e-3;
  const MapResult result = fit_error_map({samples});
  std::set<std::string> ids;
  for (const RejectedSample& sample : result.rejected) {
    ids.insert(sample.id);
    if (bad.count(sample.id) == 0) continue;
    CHECK(sample.residual == Approx(0.5e-3).epsilon(0.2));
    CHECK_THAT(sample.reason, Contains("from what the other pairs predict"));
  }
  CHECK(std::includes(ids.begin(), ids.end(), bad.begin(), bad.end()));
  CHECK(ids.size() <= bad.size() + kGoodOnesLost);
  CHECK(result.n_used == 200 - ids.size());
  CHECK(score(result.map, test::glow_field).error_over_noise < 1.3 * clean);
}

TEST_CASE("Noise alone is not sold as a gain") {
  const auto nothing = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); };
  const std::uint32_t seed = GENERATE(1U, 2U, 3U);
  const MapResult result =
      fit_error_map({test::measure(nothing, test::random_positions(100, seed), 1e-4, seed)});
  CHECK_FALSE(result.worth_using);
  CHECK(result.gain() < 0.05);
}

TEST_CASE("Repeated rows change neither the map's verdict nor its noise") {
  const auto nothing = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); };
  auto samples = test::measure(nothing, test::random_positions(60, 1), 1e-4, 1);
  const std::vector<ErrorSample> once = samples;
  samples.insert(samples.end(), once.begin(), once.end());
  const MapResult result = fit_error_map({samples});
  CHECK_FALSE(result.worth_using);
  CHECK(result.n_used == 120);
}

TEST_CASE("Errors of zero give a map of zero, inside its region") {
  const auto nothing = [](const Eigen::Vector2d&) { return Eigen::Vector2d(0.0, 0.0); };
  const MapResult result =
      fit_error_map({test::measure(nothing, test::ring_positions(40), 0.0, 1)});
  const ErrorPrediction at = predict(result.map, {0.1, 0.1});
  CHECK(at.error.norm() == 0.0);
  CHECK(at.sigma == 0.0);
  CHECK(at.inside);
  CHECK(result.gain() == 0.0);
  CHECK_FALSE(result.worth_using);
}

TEST_CASE("Few, collinear and nearly repeated samples give a finite map") {
  std::vector<Eigen::Vector2d> positions;
  SECTION("three") {
    positions = {{0.0, 0.0}, {0.1, 0.0}, {0.0, 0.1}};
  }
  SECTION("collinear") {
    for (int i = 0; i < 20; ++i) positions.emplace_back(0.02 * i, 0.01 * i);
  }
  SECTION("nearly repeated") {
    positions = test::ring_positions(100);
    for (int i = 0; i < 5; ++i)
      positions.push_back(positions[7 * i] + Eigen::Vector2d(0.5 * kMicrometre, 0.0));
  }
  const auto samples = test::measure(test::lens_field, positions, test::kFieldNoise, 1);
  const MapResult result = fit_error_map({samples});
  for (const ErrorSample& sample : samples) {
    const ErrorPrediction at = predict(result.map, sample.p_vision);
    CHECK(at.inside);
    CHECK(std::isfinite(at.sigma));
    CHECK((at.error - sample.error).norm() < 2e-3);
  }
}

TEST_CASE("What cannot be fitted is refused by a message") {
  auto samples = test::measure(test::lens_field, test::ring_positions(100), 0.0, 1);
  CHECK_THROWS_AS(fit_error_map({samples, MapMethod::kHandWidth, 0.0}), InputError);
  CHECK_THROWS_MATCHES(fit_error_map({samples, MapMethod::kHandWidth, -0.001}), InputError,
                       Refused(Cause::kInvalid, "-1 mm"));
  CHECK_THROWS_AS(fit_error_map({samples, MapMethod::kHandWidth, 2.0}), WorkError);
  samples[5].error.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_MATCHES(fit_error_map({samples}), InputError, Refused(Cause::kInvalid, "pair 5: "));
  CHECK_THROWS_MATCHES(fit_error_map({{samples.begin(), samples.begin() + 2}}), InputError,
                       Refused(Cause::kInsufficient, "2 pairs"));
}

std::vector<ErrorSample> read_samples(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<ErrorSample> samples;
  for (std::string line; std::getline(file, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    std::string id;
    Eigen::Vector2d vision_mm;
    Eigen::Vector2d tracker_mm;
    if (fields >> id >> vision_mm.x() >> vision_mm.y() >> tracker_mm.x() >> tracker_mm.y())
      samples.push_back({id, vision_mm * kMillimetre, (vision_mm - tracker_mm) * kMillimetre});
  }
  return samples;
}

TEST_CASE("On a real error field 200 pairs predict the rest better than inverse distances do") {
  const auto path = test::shared_data("plane_error_maps/plane_grid_run1.csv");
  if (!path) return;
  std::vector<ErrorSample> samples = read_samples(*path);
  REQUIRE(samples.size() == 3828);
  std::mt19937 random(1);
  std::shuffle(samples.begin(), samples.end(), random);
  const std::vector<ErrorSample> train(samples.begin(), samples.begin() + 200);
  const auto rms_on_rest_mm = [&](MapMethod method) {
    const ErrorMap map = fit_error_map({train, method}).map;
    std::vector<double> misses_mm;
    for (std::size_t i = train.size(); i < samples.size(); ++i) {
      const Eigen::Vector2d miss = samples[i].error - predict(map, samples[i].p_vision).error;
      misses_mm.push_back(miss.norm() / kMillimetre);
    }
    return rms(misses_mm);
  };
  const double rbf_mm = rms_on_rest_mm(MapMethod::kAuto);
  const double idw_mm = rms_on_rest_mm(MapMethod::kIdw);
  CAPTURE(rbf_mm, idw_mm);
  CHECK(rbf_mm < 0.029);
  CHECK(rbf_mm < 0.8 * idw_mm);
}

TEST_CASE("A map of a whole measured sheet is worth using between its circles") {
  const auto path = test::shared_data("plane_error_maps/plane_grid_run1.csv");
  if (!path) return;
  const MapResult result = fit_error_map({read_samples(*path)});
  CHECK(result.places == PlaceSource::kPositions);
  CHECK(result.worth_using);
  CHECK(result.gain() > 0.8);
  CHECK(result.gap == Approx(0.028).epsilon(0.1));
  CHECK(result.blocked.value > 0.9 * result.raw_rms);
}

TEST_CASE("An error that position does not explain is not sold as a gain, one that it does is") {
  const auto orientations = test::shared_data("tracker_pairs/ur10_grid_orientations_pairs.csv");
  const auto cubes = test::shared_data("tracker_pairs/ur10_iso_cubes_pairs.csv");
  if (!orientations || !cubes) return;
  CHECK_FALSE(fit_error_map({read_samples(*orientations)}).worth_using);
  CHECK(fit_error_map({read_samples(*cubes)}).worth_using);
}

}  // namespace
}  // namespace planar
