#include "marker/lamp_pair.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

const Eigen::Vector2d kA(100, 100), kB(200, 100), kThird(400, 300);

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
  const Eigen::Vector2d decoy(100, 200);
  const PairChoice decided = choose_pair({decoy, kA, kB}, with_prediction({110, 110}, {210, 110}));
  CHECK(decided.status == LampStatus::kOk);
  CHECK(decided.index == std::array<std::size_t, 2>{1, 2});
  const PairChoice open = choose_pair({decoy, kA, kB}, with_distance());
  CHECK(open.status == LampStatus::kAmbiguous);
  CHECK_FALSE(open.is_unique);
}

}  // namespace
}  // namespace planar
