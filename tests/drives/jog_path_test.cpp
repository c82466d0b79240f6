#include "planar_servo/hardware/drives/grbl_axes.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/hardware/drives/grbl_protocol.h"

namespace planar {
namespace {

constexpr double kAcceleration = 100.0;
constexpr double kTopSpeed = 10.0;
const std::array<AxisLimits, 3> kEqual{AxisLimits{250.0, kTopSpeed, kAcceleration},
                                       AxisLimits{250.0, kTopSpeed, kAcceleration},
                                       AxisLimits{250.0, kTopSpeed, kAcceleration}};

/// The time to travel `way` from a speed to rest as fast as the limits allow, in small steps.
double duration_of(double way, double speed) {
  constexpr double kStep_s = 1e-5;
  double duration_s = 0.0;
  for (; way > 1e-9; duration_s += kStep_s) {
    const double wanted = std::min(kTopSpeed, std::sqrt(2.0 * kAcceleration * way));
    speed = std::min(wanted, speed + kAcceleration * kStep_s);
    way -= std::max(speed, 1e-4) * kStep_s;
  }
  return duration_s;
}

TEST_CASE("What is within reach is travelled in the given time, from rest and at speed") {
  for (const double speed : {0.0, 3.0, 7.0, 10.0})
    for (const double duration_s : {0.12, 0.2, 0.5})
      CHECK(duration_of(reach(speed, kTopSpeed, kAcceleration, duration_s), speed) ==
            Approx(duration_s).margin(0.01));
}

TEST_CASE("No axis is asked for more than its limits, and one is driven at them") {
  auto limits = kEqual;
  limits[1].speed_mm_s = 2.0;
  CHECK(JogPath({0, 0, 0}, {500, 0, 0}, limits).speed_mm_s() == Approx(10.0));
  CHECK(JogPath({0, 0, 0}, {300, 400, 0}, limits).speed_mm_s() == Approx(2.5));
}

TEST_CASE("A way is handed out piece by piece, on its line, and ends in its target") {
  const AxisPulses from(100, -50, 7), to(20100, 9950, 10007);
  JogPath path(from, to, kEqual);
  AxisPulses here = from;
  int pieces = 0;
  while (!path.all_sent()) {
    const auto piece = path.next_piece(here);
    REQUIRE(piece.has_value());
    CHECK(std::abs((*piece - from).x() - 2 * (*piece - from).y()) <= 2);
    CHECK(((*piece - here).cast<double>() / 250.0).norm() <= kTopSpeed * grbl::kLongestRun_s);
    here = *piece;
    ++pieces;
  }
  CHECK(here == to);
  CHECK(pieces > 10);
}

TEST_CASE("While the axes do not move, nothing more is handed out") {
  JogPath path({0, 0, 0}, {20000, 0, 0}, kEqual);
  while (path.next_piece({0, 0, 0})) {
  }
  CHECK(path.sent().x() > 0);
  CHECK(path.sent().x() / 250.0 <=
        reach(0.0, kTopSpeed, kAcceleration, grbl::kLongestRun_s) + 0.01);
  CHECK(path.next_piece({150, 0, 0}).has_value());
}

TEST_CASE("The rest of the way before counts as queued") {
  JogPath path({5000, 0, 0}, {5000, 9000, 0}, kEqual);
  CHECK_FALSE(path.next_piece({4000, 0, 0}).has_value());
  CHECK(path.next_piece({4990, 0, 0}).has_value());
}

TEST_CASE("A way leads on to targets for which no axis has to turn round") {
  JogPath path({0, 0, 0}, {1000, -500, 0}, kEqual);
  path.next_piece({0, 0, 0});
  const AxisPulses end = path.sent();
  REQUIRE(end.x() > 1);
  CHECK(path.leads_to(end + AxisPulses(100, 0, -7), {0, 0, 0}));
  CHECK_FALSE(path.leads_to(end - AxisPulses(1, 0, 0), {0, 0, 0}));
  CHECK_FALSE(path.leads_to(end + AxisPulses(100, 1, 0), {0, 0, 0}));
  CHECK(path.leads_to(end - AxisPulses(1, 0, 0), end));
}

TEST_CASE("A way without length is travelled at once") {
  JogPath path({5, 6, 7}, {5, 6, 7}, kEqual);
  CHECK(path.all_sent());
  CHECK_FALSE(path.next_piece({5, 6, 7}).has_value());
}

}  // namespace
}  // namespace planar
