#include "planar_servo/work/record/board_source.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/pose.h"

namespace planar {
namespace {

using Catch::Contains;

const Board kGuidedBoard{Board::Kind::kCircles, 5, 4, 0.01};
const cv::Size kSensor_px(1000, 1000);
constexpr double kExposure_s = 0.01;

/// A board without tilt about this pixel, turned by this angle.
BoardSight sight_at(double u, double v, double turn = 0.0, double pitch_px = 40.0) {
  BoardSight sight;
  const Eigen::Matrix2d R = rotation2d(turn);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 5; ++column)
      sight.pixels.push_back(Eigen::Vector2d(u, v) +
                             R * Eigen::Vector2d(pitch_px * (column - 2), pitch_px * (row - 1.5)));
  return sight;
}

BoardSight lattice_of(std::size_t dots) {
  BoardSight sight;
  sight.dots_in_a_grid = dots;
  return sight;
}

/// Looks at what stays as it is, ten times a second. Returns when it was taken; negative when it
/// was not.
double taken_after_s(BoardGuide& guide, const BoardSight& sight, std::size_t left, double begin_s,
                     double for_s = 20.0) {
  for (int i = 0; i < 10.0 * for_s; ++i)
    if (guide.look(begin_s + 0.1 * i, sight, left).next == BoardAdvice::Next::kTake) return 0.1 * i;
  return -1.0;
}

TEST_CASE("A board that stands still and shows what is missing is taken, a moving one is not") {
  BoardGuide guide(Purpose::kHeldBoard, kGuidedBoard, kSensor_px, kExposure_s);
  for (int i = 0; i < 50; ++i) {
    const BoardAdvice advice = guide.look(0.1 * i, sight_at(200.0 + 6.0 * i, 150.0), 1);
    CHECK(advice.next != BoardAdvice::Next::kTake);
    CHECK_THAT(advice.state, Contains("hold it still"));
  }
  CHECK(taken_after_s(guide, sight_at(180.0, 150.0), 1, 5.0) == Approx(0.7));
}

TEST_CASE("The same view is never taken twice, however long it is held") {
  BoardGuide guide(Purpose::kHeldBoard, kGuidedBoard, kSensor_px, kExposure_s);
  guide.take("g1", sight_at(500.0, 500.0).pixels);
  CHECK(taken_after_s(guide, sight_at(510.0, 500.0), 9, 0.0, 60.0) < 0.0);
  CHECK_THAT(guide.look(61.0, sight_at(510.0, 500.0), 9).state, Contains("in the middle, like g1"));
  CHECK(guide.covered_px().size() == 20);
}

TEST_CASE(
    "A view that shows nothing missing is taken after a while, if it is held up all the time") {
  BoardGuide guide(Purpose::kHeldBoard, kGuidedBoard, kSensor_px, kExposure_s);
  CHECK(taken_after_s(guide, sight_at(500.0, 500.0), 1, 0.0) == Approx(8.7).margin(0.11));
  BoardGuide other(Purpose::kHeldBoard, kGuidedBoard, kSensor_px, kExposure_s);
  CHECK(taken_after_s(other, sight_at(500.0, 500.0), 1, 0.0, 6.0) < 0.0);
  CHECK_THAT(other.look(6.0, sight_at(500.0, 500.0), 1).state, Contains("taken in 3 s"));
  CHECK(taken_after_s(other, sight_at(500.0, 650.0), 1, 6.1, 6.0) < 0.0);
}

TEST_CASE(
    "A laid board must lie more still than a hand can hold it, and differ from the view before") {
  BoardGuide guide(Purpose::kLaidBoard, kGuidedBoard, kSensor_px, kExposure_s);
  for (int i = 0; i < 100; ++i)
    CHECK(guide.look(0.1 * i, sight_at(500.0 + i % 2, 500.0), 1).next != BoardAdvice::Next::kTake);
  guide.pass_over(sight_at(500.0, 500.0).pixels);
  CHECK(taken_after_s(guide, sight_at(500.0, 500.0), 1, 10.0) < 0.0);
  CHECK(taken_after_s(guide, sight_at(500.0, 500.0, 0.3), 1, 40.0) == Approx(1.5));
}

TEST_CASE("What is seen of a board that is not whole, or is another one, is said") {
  BoardGuide guide(Purpose::kHeldBoard, kGuidedBoard, kSensor_px, kExposure_s);
  CHECK(guide.look(0.0, lattice_of(0), 1).state == "no board of 5 x 4 dots in the picture");
  CHECK_THAT(guide.look(0.1, lattice_of(15), 1).state,
             Contains("15 of 20 dots seen, the others outside, covered or blurred"));
  CHECK_THAT(guide.look(0.2, lattice_of(30), 1).state,
             Contains("a grid of 30 dots seen, the board has 20"));
  // A board that was covered for a moment begins to stand still anew.
  guide.look(0.3, sight_at(180.0, 150.0), 1);
  guide.look(0.9, lattice_of(15), 1);
  CHECK(guide.look(1.1, sight_at(180.0, 150.0), 1).next != BoardAdvice::Next::kTake);
}

}  // namespace
}  // namespace planar
