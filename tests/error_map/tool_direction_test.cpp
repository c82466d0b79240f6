#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "support/error_fields.h"
#include "support/refused.h"
#include "support/shared_data.h"

namespace planar {
namespace {

using test::Refused;

const Eigen::Vector2d kBias(0.08e-3, -0.06e-3);  // 0.1 mm in the tool's frame

Eigen::Vector2d in_base_frame(const Eigen::Vector2d& t, double phi) {
  return {t.x() * std::cos(phi) - t.y() * std::sin(phi),
          t.x() * std::sin(phi) + t.y() * std::cos(phi)};
}

std::vector<ErrorSample> samples_of(int count, std::uint32_t seed) {
  return test::measure(test::lens_field, test::random_positions(count, seed), test::kFieldNoise,
                       seed);
}

/// The same with the tool in any direction, and an error fixed in its frame.
std::vector<ErrorSample> directed_samples(int count, std::uint32_t seed,
                                          const Eigen::Vector2d& bias) {
  std::vector<ErrorSample> samples = samples_of(count, seed);
  std::mt19937 random(seed + 1000);
  std::uniform_real_distribution<double> direction(-kPi, kPi);
  for (ErrorSample& sample : samples) {
    sample.phi = direction(random);
    sample.error += in_base_frame(bias, *sample.phi);
  }
  return samples;
}

/// Root mean square per axis of what the map leaves of other samples.
double rms_left(const ErrorMap& map, const std::vector<ErrorSample>& others) {
  std::vector<double> misses;
  for (const ErrorSample& sample : others)
    for (const double miss :
         Eigen::Vector2d(sample.error - predict_error(map, sample.p_vision, sample.phi)))
      misses.push_back(miss);
  return rms(misses);
}

void forget_directions(std::vector<ErrorSample>& samples) {
  for (ErrorSample& sample : samples) sample.phi.reset();
}

TEST_CASE("An error fixed in the tool's frame is found and leaves nearly the noise") {
  const std::uint32_t seed = GENERATE(1U, 2U, 3U);
  std::vector<ErrorSample> samples = directed_samples(200, seed, kBias);
  const auto others = directed_samples(500, seed + 10, kBias);
  const MapResult result = fit_error_map({samples});
  REQUIRE(depends_on_direction(result.map));
  const ToolBias bias = tool_bias(result.map).value();
  constexpr double kSigmas = 4.0;  // one axis in 16,000
  CHECK((bias.t - kBias).cwiseAbs().maxCoeff() < kSigmas * bias.sigma);
  const double of_mean = test::kFieldNoise / std::sqrt(200.0);
  CHECK(bias.sigma < 2.0 * of_mean);
  constexpr double kWithTheMapsOwn =
      1.2;  // on this field the map misses by 0.4 of the noise itself
  CHECK(rms_left(result.map, others) < kWithTheMapsOwn * test::kFieldNoise);
  forget_directions(samples);
  CHECK(rms_left(fit_error_map({samples}).map, others) > 0.9 * kBias.norm() / std::sqrt(2.0));
}

TEST_CASE("The standard deviation of a map with directions holds its misses") {
  const MapResult result = fit_error_map({directed_samples(200, 4, kBias)});
  const auto others = directed_samples(500, 14, kBias);
  int covered = 0;
  for (const ErrorSample& sample : others) {
    const ErrorPrediction at = predict(result.map, sample.p_vision, sample.phi);
    const double sigma = std::hypot(at.sigma, test::kFieldNoise);
    covered += static_cast<int>(((sample.error - at.error).array().abs() <= 1.96 * sigma).count());
  }
  CHECK(covered / 1000.0 == Approx(0.95).margin(0.03));
}

/// Whether two maps agree bit for bit, at samples that name the tool's direction.
bool are_same(const MapResult& a, const MapResult& b) {
  const auto& of_a = std::get<RbfMap>(a.map).parameters();
  const auto& of_b = std::get<RbfMap>(b.map).parameters();
  return of_a.weights == of_b.weights && of_a.tail == of_b.tail && of_a.ridge == of_b.ridge &&
         of_a.kernel.width == of_b.kernel.width && of_a.signal_sigma == of_b.signal_sigma &&
         of_a.directions.cols() == of_b.directions.cols() && a.loo_rms == b.loo_rms;
}

TEST_CASE("Directions that do not matter, or do not change, leave the map as it is bit for bit") {
  std::vector<ErrorSample> samples = directed_samples(200, 1, {0.0, 0.0});
  SECTION("no error depends on them") {}
  SECTION("all are alike") {
    for (ErrorSample& sample : samples) sample.phi = 0.3;
  }
  SECTION("all are alike but for what a camera takes them for") {
    for (ErrorSample& sample : samples) sample.phi = 1e-3 * *sample.phi;
  }
  SECTION("one pair names none") {
    samples[7].phi.reset();
  }
  const MapResult result = fit_error_map({samples});
  CHECK_FALSE(depends_on_direction(result.map));
  CHECK_FALSE(tool_bias(result.map).has_value());
  forget_directions(samples);
  CHECK(are_same(result, fit_error_map({samples})));
}

TEST_CASE("Directions that turn with the position are not told from it") {
  std::vector<ErrorSample> samples = samples_of(200, 1);
  for (ErrorSample& sample : samples) sample.phi = std::asin(sample.p_vision.x());
  CHECK_FALSE(depends_on_direction(fit_error_map({samples}).map));
}

TEST_CASE("Outliers are found beside an error fixed in the tool's frame") {
  std::vector<ErrorSample> samples = directed_samples(200, 1, kBias);
  samples[20].error.x() += 0.2e-3;
  const MapResult result = fit_error_map({samples});
  REQUIRE(depends_on_direction(result.map));
  REQUIRE(result.rejected.size() == 1);
  CHECK(result.rejected.front().id == "20");
}

TEST_CASE("A position seen with the tool in several directions has the mean of them") {
  std::vector<ErrorSample> samples = directed_samples(100, 1, kBias);
  for (int i = 0; i < 20; ++i) {
    samples.push_back(samples[static_cast<std::size_t>(i)]);
    ErrorSample& again = samples.back();
    again.error -= in_base_frame(kBias, *again.phi);
    *again.phi += 2.0;
    again.error += in_base_frame(kBias, *again.phi);
  }
  const MapResult result = fit_error_map({samples});
  REQUIRE(depends_on_direction(result.map));
  const auto& map = std::get<RbfMap>(result.map);
  CHECK(map.parameters().centers.cols() == 100);
  const ToolBias bias = tool_bias(result.map).value();
  CHECK((bias.t - kBias).norm() < 0.05 * kBias.norm());
}

TEST_CASE("A map that depends on the tool's direction does not answer without it") {
  const ErrorMap map = fit_error_map({directed_samples(100, 1, kBias)}).map;
  REQUIRE(depends_on_direction(map));
  CHECK_NOTHROW(predict(map, {0.1, 0.1}, 0.0));
  CHECK_THROWS_AS(predict(map, {0.1, 0.1}), std::invalid_argument);
  CHECK_THROWS_AS(predict_error(map, {0.1, 0.1}), std::invalid_argument);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(predict(map, {0.1, 0.1}, kNan), std::invalid_argument);
}

/// The UR10's pairs with its goal's pitch, by which its orientation varies most, as the direction.
std::vector<ErrorSample> real_samples(const std::filesystem::path& pairs,
                                      const std::filesystem::path& goals) {
  const auto fields_of = [](std::string line, char separator) {
    std::replace(line.begin(), line.end(), separator, ' ');
    std::istringstream stream(line);
    return std::vector<std::string>(std::istream_iterator<std::string>(stream), {});
  };
  std::vector<double> pitches;
  std::ifstream goal_file(goals);
  std::string line;
  std::getline(goal_file, line);
  while (std::getline(goal_file, line)) {
    std::replace(line.begin(), line.end(), ',', '.');
    pitches.push_back(std::stod(fields_of(line, ';').at(5)));
  }
  std::vector<ErrorSample> samples;
  std::ifstream pair_file(pairs);
  while (std::getline(pair_file, line)) {
    if (line.front() == '#' || line.front() == 'i') continue;
    const auto fields = fields_of(line, ',');
    const Eigen::Vector2d vision_mm(std::stod(fields.at(1)), std::stod(fields.at(2)));
    const Eigen::Vector2d tracker_mm(std::stod(fields.at(3)), std::stod(fields.at(4)));
    samples.push_back({fields[0], vision_mm * kMillimetre, (vision_mm - tracker_mm) * kMillimetre,
                       0.0, pitches.at(std::stoul(fields[0]))});
  }
  return samples;
}

TEST_CASE("Directions that explain nothing of a real error are not sold as a gain") {
  const auto pairs = test::shared_data("tracker_pairs/ur10_grid_orientations_pairs.csv");
  const auto goals = test::shared_data("tracker_pairs/ur10_grid_orientations.csv");
  if (!pairs || !goals) return;
  const MapResult result = fit_error_map({real_samples(*pairs, *goals)});
  CHECK_FALSE(depends_on_direction(result.map));
  CHECK_FALSE(result.worth_using);
}

TEST_CASE("A direction that is not finite is refused by its pair") {
  std::vector<ErrorSample> samples = directed_samples(100, 1, kBias);
  samples[5].phi = std::numeric_limits<double>::infinity();
  CHECK_THROWS_MATCHES(fit_error_map({samples}), InputError, Refused(Cause::kInvalid, "pair 5: "));
}

}  // namespace
}  // namespace planar
