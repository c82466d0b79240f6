#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/offline/map/map_report.h"
#include "support/error_fields.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

constexpr double kRounding = 1e-12;

std::vector<PairRow> pairs_of(const std::vector<ErrorSample>& samples,
                              std::optional<Purpose> plan) {
  std::vector<PairRow> pairs;
  for (const ErrorSample& sample : samples) {
    PairRow pair;
    pair.id = sample.id;
    pair.p_vision = sample.p_vision;
    pair.p_tracker = sample.p_vision - sample.error;
    pair.plan = plan;
    pairs.push_back(pair);
  }
  return pairs;
}

std::vector<PairRow> lens_pairs(std::uint32_t seed, std::optional<Purpose> plan) {
  return pairs_of(
      test::measure(test::lens_field, test::random_positions(200, seed), test::kFieldNoise, seed),
      plan);
}

TEST_CASE("A method is chosen by its name, the paper's by its width in millimetres") {
  CHECK(parse_map_method("auto").method == MapMethod::kAuto);
  CHECK(parse_map_method("idw").method == MapMethod::kIdw);
  CHECK(parse_map_method("hand:48").method == MapMethod::kHandWidth);
  CHECK(parse_map_method("hand:48").hand_width == Approx(0.048));
  for (const char* wrong : {"", "RBF", "hand", "hand:", "hand:48mm"})
    CHECK_THROWS_MATCHES(parse_map_method(wrong), InputError, Refused(Cause::kInvalid, "--method"));
}

TEST_CASE("A map is fitted to the pairs of plan train, and judged on the others") {
  std::vector<PairRow> pairs = lens_pairs(1, Purpose::kTrain);
  const std::vector<PairRow> others = lens_pairs(2, Purpose::kTest);
  pairs.insert(pairs.end(), others.begin(), others.end());
  const FitErrorMapReport report = fit_error_map_to_pairs(pairs, {});
  CHECK(report.result.n_used == 200);
  CHECK(report.n_other_plans == 200);
  CHECK(pairs_to_check(pairs, {}).size() == 200);
  pairs[7].p_tracker.reset();
  CHECK(fit_error_map_to_pairs(pairs, {}).n_unattended == 1);
  pairs[207].p_tracker.reset();
  CHECK(pairs_to_check(pairs, {}).size() == 199);
  pairs = lens_pairs(1, Purpose::kTrain);
  pairs.insert(pairs.end(), others.begin(), others.end());
  CHECK(pairs_to_check(pairs, {Purpose::kTrain, Purpose::kTest}).size() == 400);
  CHECK(pairs_to_check(lens_pairs(1, {}), {}).size() == 200);
  CHECK_THROWS_MATCHES(fit_error_map_to_pairs(others, {}), InputError,
                       Refused(Cause::kMissing, "'train'"));
  CHECK_THROWS_MATCHES(pairs_to_check(others, {Purpose::kControl}), InputError,
                       Refused(Cause::kMissing, "plan control"));
}

TEST_CASE(
    "A fit takes the places of its pairs from their column, and the report tells their noise") {
  std::vector<PairRow> pairs = lens_pairs(1, {});
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::size_t first = i - i % 2;
    const Eigen::Vector2d shared = pairs[first].error();
    pairs[i].p_vision = pairs[first].p_vision;
    pairs[i].p_tracker = pairs[i].p_vision - shared;
    if (i % 2 == 1) *pairs[i].p_tracker += Eigen::Vector2d(2e-6, 0.0);
    pairs[i].place = "p" + std::to_string(i / 2);
  }
  const FitErrorMapReport report = fit_error_map_to_pairs(pairs, {});
  CHECK(report.result.places == PlaceSource::kNamed);
  const std::string text = map_fit_list(report, {}).text();
  CHECK_THAT(text, Contains("places              100, as named"));
  CHECK_THAT(text, Contains("mm per axis of a place, 0.0010 mm of a reading"));
  CHECK_THAT(text, Contains("in a gap") && Contains("mm are without pairs"));
  const nlohmann::json keys = map_fit_list(report, {}).json();
  CHECK(keys["places"] == "named");
  CHECK(keys["n_places"] == 100);
  CHECK(keys["reading_noise_mm"].get<double>() == Approx(0.001).epsilon(0.01));
  CHECK(keys["place_noise_mm"].get<double>() > 0.005);
  CHECK(keys["gap_mm"].get<double>() > 10.0);
}

TEST_CASE("The check's figures are those of theory") {
  IdwMap constant;  // predicts (1, 0) mm everywhere
  constant.centers = Eigen::Matrix2Xd::Zero(2, 1);
  constant.errors = Eigen::Vector2d(1e-3, 0.0);
  constant.region = {{{0.0, 0.0}, {0.1, 0.0}, {0.0, 0.1}}, 0.0};
  const std::vector<PairRow> pairs = pairs_of({{"a", {0.01, 0.01}, {1e-3, 0.0}},
                                               {"b", {0.02, 0.02}, {0.0, 2e-3}},
                                               {"c", {0.5, 0.5}, {3e-3, 0.0}}},
                                              {});
  const MapCheck check = check_error_map(constant, pairs);
  const double mean_missed = (0.0 + std::sqrt(5.0) + 2.0) / 3.0;
  CHECK(check.n_outside == 1);
  CHECK(check.raw.mean / kMillimetre == Approx(2.0));
  CHECK(check.compensated.mean / kMillimetre == Approx(mean_missed));
  CHECK(check.compensated.max / kMillimetre == Approx(std::sqrt(5.0)));
  CHECK(check.a1 == Approx(1.0 - mean_missed / 2.0));
  CHECK(check.a2 == Approx(0.5).epsilon(kRounding));
  CHECK(std::isnan(check.coverage_95));
}

TEST_CASE("A map is not judged on pairs in another unit or frame, but on one or two pairs") {
  const ErrorMap map = fit_error_map_to_pairs(lens_pairs(1, {}), {}).result.map;
  std::vector<PairRow> pairs = lens_pairs(2, {});
  CHECK_NOTHROW(check_error_map(map, {pairs.front()}));
  std::vector<PairRow> swapped = pairs;
  for (PairRow& pair : swapped) pair.p_tracker = pair.p_tracker->reverse().eval();
  CHECK_THROWS_MATCHES(check_error_map(map, swapped), InputError,
                       Refused(Cause::kContradiction, "x and y"));
  for (PairRow& pair : pairs) *pair.p_tracker *= kMillimetre;
  CHECK_THROWS_MATCHES(check_error_map(map, pairs), InputError,
                       Refused(Cause::kContradiction, "like metres"));
}

TEST_CASE("A map that depends on the tool's direction is not judged on pairs without it") {
  std::vector<PairRow> pairs = lens_pairs(1, {});
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].phi = 2.4 * static_cast<double>(i * i);
    *pairs[i].p_tracker -= 1e-4 * Eigen::Vector2d(std::cos(*pairs[i].phi), std::sin(*pairs[i].phi));
  }
  const ErrorMap map = fit_error_map_to_pairs(pairs, {}).result.map;
  CHECK_NOTHROW(require_what_it_needs(map, pairs, "pairs.csv"));
  CHECK(check_error_map(map, pairs).compensated.rms < 3.0 * test::kFieldNoise);
  pairs[3].phi.reset();
  for (const char* name : {"pairs.csv", "phi_deg"})
    CHECK_THROWS_MATCHES(require_what_it_needs(map, pairs, "pairs.csv"), InputError,
                         Refused(Cause::kMissing, name));
  CHECK_NOTHROW(
      require_what_it_needs(fit_error_map_to_pairs(lens_pairs(1, {}), {}).result.map, pairs, ""));
}

TEST_CASE("About 95 of 100 other pairs lie within the interval of map and noise") {
  const ErrorMap map = fit_error_map_to_pairs(lens_pairs(1, {}), {}).result.map;
  std::vector<PairRow> others = lens_pairs(2, {});
  CHECK(check_error_map(map, others).coverage_95 == Approx(0.95).margin(0.03));
  for (PairRow& pair : others) pair.sigma_tracker = 3.0 * test::kFieldNoise;
  CHECK(check_error_map(map, others).coverage_95 > 0.99);
}

}  // namespace
}  // namespace planar
