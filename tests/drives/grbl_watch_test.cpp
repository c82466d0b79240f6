#include "planar_servo/hardware/drives/grbl_axes.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

/// A watch over a board of 250 pulses per millimetre that rests at 0.
struct WatchedBoard {
  WatchedBoard() { report({0, 0, 0}); }

  void report(const AxisPulses& place, const std::string& pins = "") {
    const Eigen::Vector3d mm = place.cast<double>() / 250.0;
    grbl::Report said;
    said.position_mm = {mm.x(), mm.y(), mm.z()};
    said.pins = pins;
    watch.take(said);
  }

  GrblWatch watch{Eigen::Vector3d(250.0, 250.0, 250.0)};
};

TEST_CASE("Places within the box of the way are believed at once") {
  WatchedBoard board;
  board.watch.extend_way({100, -50, 0});
  board.report({60, -20, 1});
  CHECK(board.watch.here() == AxisPulses(60, -20, 1));
  CHECK(board.watch.on_way());
}

TEST_CASE("A place off the way is believed when the next report is off it, too") {
  WatchedBoard board;
  board.report({0, 90, 0});
  CHECK(board.watch.here() == AxisPulses(0, 0, 0));
  CHECK_FALSE(board.watch.settled());
  board.report({0, 0, 0});
  board.report({0, 90, 0});
  CHECK(board.watch.on_way());
  board.report({0, 91, 0});
  CHECK(board.watch.here() == AxisPulses(0, 91, 0));
  CHECK_FALSE(board.watch.on_way());
  CHECK(board.watch.off_way_words().find("0, 91, 0 pulses instead of between 0, ") !=
        std::string::npos);
}

TEST_CASE("After the way was forgotten, the next place is believed") {
  WatchedBoard board;
  board.watch.forget_way();
  CHECK(board.watch.on_way());
  board.report({7000, 8000, 9000});
  CHECK(board.watch.here() == AxisPulses(7000, 8000, 9000));
  CHECK(board.watch.settled());
}

TEST_CASE("Axes slow down while they turn, not when they rest") {
  GrblWatch watch(Eigen::Vector3d(250.0, 250.0, 250.0));
  const auto slows_at = [&](double speed_mm_min, bool turns) {
    grbl::Report said;
    said.speed_mm_min = speed_mm_min;
    said.turns = turns;
    watch.take(said);
    return watch.slows();
  };
  CHECK_FALSE(slows_at(900.0, true));
  CHECK_FALSE(slows_at(890.0, true));
  CHECK(slows_at(700.0, true));
  CHECK(slows_at(700.0, true));
  CHECK_FALSE(slows_at(710.0, true));
  CHECK(slows_at(600.0, true));
  CHECK_FALSE(slows_at(0.0, false));
  CHECK_FALSE(slows_at(100.0, true));
}

TEST_CASE("An input counts when two reports in a row have it pressed since the move began") {
  WatchedBoard board;
  board.report({0, 0, 0}, "Y");
  board.watch.begin_move();
  board.report({0, 0, 0}, "XY");
  CHECK_FALSE(board.watch.newly_pressed('X'));
  board.report({0, 0, 0}, "XY");
  CHECK(board.watch.newly_pressed('X'));
  CHECK_FALSE(board.watch.newly_pressed('Y'));
  for (const char* pins : {"", "", "Y", "Y"}) board.report({0, 0, 0}, pins);
  CHECK_FALSE(board.watch.newly_pressed('X'));
  CHECK(board.watch.newly_pressed('Y'));
}

TEST_CASE("An input that one garbled report leaves out counts as pressed since before the move") {
  WatchedBoard board;
  for (const char* pins : {"X", "X", ""}) board.report({0, 0, 0}, pins);
  board.watch.begin_move();
  for (int i = 0; i < 2; ++i) board.report({0, 0, 0}, "X");
  CHECK_FALSE(board.watch.newly_pressed('X'));
}

TEST_CASE("Garbled reports end a move when three come in a row, other garbage at once") {
  WatchedBoard board;
  const grbl::Garbage garbled{"<Jo", true}, noise{"#7", false};
  CHECK_FALSE(board.watch.minds(garbled));
  CHECK_FALSE(board.watch.minds(garbled));
  board.report({0, 0, 0});
  CHECK_FALSE(board.watch.minds(garbled));
  CHECK_FALSE(board.watch.minds(garbled));
  CHECK(board.watch.minds(garbled));
  CHECK(WatchedBoard().watch.minds(noise));
}

}  // namespace
}  // namespace planar
