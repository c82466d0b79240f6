#include "planar_servo/lamps/lamp_tracker.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

Blob light(double u, double v, double diameter_px = 20.0, double contrast = 150.0) {
  Blob blob;
  blob.uv_px = {u, v};
  blob.area_px2 = 0.25 * kPi * diameter_px * diameter_px;
  blob.level = 12.0 + contrast;
  blob.background = 12.0;
  return blob;
}

const Blob kA = light(100, 100), kB = light(200, 100), kThird = light(400, 300);

PairExpectation with_distance() {
  PairExpectation expectation;
  expectation.separation_px = {90.0, 110.0};
  return expectation;
}

PairExpectation with_prediction(const Eigen::Vector2d& first, const Eigen::Vector2d& second) {
  PairExpectation expectation = with_distance();
  expectation.predicted_px = {first, second};
  return expectation;
}

TEST_CASE("choose_pair says when there is no lamp or only one") {
  CHECK(choose_pair({}, with_distance()).status == LampStatus::kNoLamp);
  CHECK(choose_pair({kA}, with_distance()).status == LampStatus::kOneLamp);
}

TEST_CASE("choose_pair refuses two lights at the wrong distance") {
  CHECK(choose_pair({kA, kThird}, with_distance()).status == LampStatus::kWrongDistance);
}

TEST_CASE("choose_pair names the lamps by the predicted places, in both orders") {
  const PairChoice same = choose_pair({kA, kB}, with_prediction({105, 120}, {190, 115}));
  CHECK(same.status == LampStatus::kOk);
  CHECK(same.index == std::array<std::size_t, 2>{0, 1});
  const PairChoice swapped = choose_pair({kA, kB}, with_prediction({190, 115}, {105, 120}));
  CHECK(swapped.status == LampStatus::kOk);
  CHECK(swapped.index == std::array<std::size_t, 2>{1, 0});
}

TEST_CASE("choose_pair leaves the names open without a prediction or with one across the pair") {
  const PairChoice unnamed = choose_pair({kA, kB}, with_distance());
  CHECK(unnamed.status == LampStatus::kAmbiguous);
  CHECK(unnamed.is_unique);
  const PairChoice across = choose_pair({kA, kB}, with_prediction({150, 50}, {152, 150}));
  CHECK(across.status == LampStatus::kAmbiguous);
}

TEST_CASE("choose_pair is not disturbed by a third light at another distance") {
  const PairChoice choice = choose_pair({kThird, kA, kB}, with_distance());
  CHECK(choice.is_unique);
  CHECK(choice.index == std::array<std::size_t, 2>{1, 2});
}

TEST_CASE("choose_pair lets the prediction decide about a third light at the right distance") {
  const Blob decoy = light(100, 200);
  const PairChoice decided = choose_pair({decoy, kA, kB}, with_prediction({110, 110}, {210, 110}));
  CHECK(decided.status == LampStatus::kOk);
  CHECK(decided.index == std::array<std::size_t, 2>{1, 2});
  const PairChoice open = choose_pair({decoy, kA, kB}, with_distance());
  CHECK(open.status == LampStatus::kAmbiguous);
  CHECK_FALSE(open.is_unique);
}

/// Lamps 100 px apart whose diameters are in the ratio of `first_px` to `second_px`.
PairExpectation with_diameters(double first_px, double second_px) {
  PairExpectation expectation;
  expectation.diameter_over_separation = {first_px / 100.0, second_px / 100.0};
  return expectation;
}

TEST_CASE("choose_pair tells lamps of different size apart without a prediction") {
  const Blob small = light(100, 100, 20.0), large = light(200, 100, 26.0);
  const PairChoice choice = choose_pair({large, small}, with_diameters(20.0, 26.0));
  CHECK(choice.status == LampStatus::kOk);
  CHECK(choice.index == std::array<std::size_t, 2>{1, 0});
  CHECK(choose_pair({kA, kB}, with_diameters(20.0, 26.0)).status == LampStatus::kAmbiguous);
  CHECK(choose_pair({large, small}, with_diameters(20.0, 20.5)).status == LampStatus::kAmbiguous);
}

TEST_CASE("choose_pair knows lamps by their size in any scale and leaves out lights of another") {
  const Blob far = light(100, 100, 5.0), near = light(125, 100, 6.5);
  CHECK(choose_pair({far, near}, with_diameters(20.0, 26.0)).status == LampStatus::kOk);
  const Blob flood = light(150, 150, 60.0);
  const PairChoice choice = choose_pair({flood, kA, kB}, with_diameters(20.0, 20.0));
  CHECK(choice.is_unique);
  CHECK(choice.index == std::array<std::size_t, 2>{1, 2});
}

TEST_CASE("choose_pair trusts neither when looks and prediction contradict each other") {
  PairExpectation expectation = with_prediction({100, 100}, {200, 100});
  expectation.diameter_over_separation = {0.2, 0.26};
  const Blob small = light(100, 100, 20.0), large = light(200, 100, 26.0);
  CHECK(choose_pair({small, large}, expectation).status == LampStatus::kOk);
  std::swap((*expectation.predicted_px)[0], (*expectation.predicted_px)[1]);
  CHECK(choose_pair({small, large}, expectation).status == LampStatus::kAmbiguous);
}

TEST_CASE("choose_pair lets the looks decide when the pair lies across the prediction") {
  PairExpectation expectation = with_prediction({150, 50}, {152, 150});
  expectation.diameter_over_separation = {0.26, 0.2};
  const Blob small = light(100, 100, 20.0), large = light(200, 100, 26.0);
  const PairChoice choice = choose_pair({small, large}, expectation);
  CHECK(choice.status == LampStatus::kOk);
  CHECK(choice.index == std::array<std::size_t, 2>{1, 0});
}

}  // namespace
}  // namespace planar
