#include "support/emulated_tic.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/manual_clock.h"

namespace planar::test {
namespace {

constexpr double kStep_s = 2e-4;  // the emulation's own step of time

/// The Tic as its wire shows it, asked by bytes.
struct Bench {
  void command(std::uint8_t request, std::uint16_t value = 0, std::uint16_t index = 0) {
    REQUIRE(tic.control({0x40, request, value, index, 0}, nullptr).status == 0);
  }
  void command32(std::uint8_t request, std::int32_t value) {
    const auto bits = static_cast<std::uint32_t>(value);
    command(request, static_cast<std::uint16_t>(bits & 0xffff),
            static_cast<std::uint16_t>(bits >> 16));
  }
  std::int32_t variable(std::uint16_t offset, int bytes) {
    std::uint8_t data[4]{};
    const UsbOutcome outcome =
        tic.control({0xc0, 0xa1, 0, offset, static_cast<std::uint16_t>(bytes)}, data);
    REQUIRE(outcome.bytes == static_cast<std::size_t>(bytes));
    return static_cast<std::int32_t>(data[0] | data[1] << 8 | data[2] << 16 |
                                     static_cast<std::uint32_t>(data[3]) << 24);
  }
  std::int32_t position() { return variable(0x22, 4); }
  std::int32_t velocity() { return variable(0x26, 4); }
  int state() { return variable(0x00, 1); }
  int errors() { return variable(0x02, 2); }
  bool uncertain() { return (variable(0x01, 1) & 2) != 0; }
  bool homing() { return (variable(0x01, 1) & 16) != 0; }

  /// Lets time pass, with or without feeding the command timeout.
  void wait(double duration_s, bool fed = true) {
    for (double waited_s = 0.0; waited_s < duration_s; waited_s += 0.05) {
      if (fed) command(0x8c);
      clock.sleep_for_s(std::min(0.05, duration_s - waited_s));
    }
  }
  void switch_on() {
    command(0x85);
    command(0x83);
    wait(0.05);
  }

  ManualClock clock;
  std::int32_t seen{0};
  EmulatedTic tic{clock, [this](std::int32_t shaft) { seen = shaft; }};
};

struct ReadyBench : Bench {
  ReadyBench() {
    switch_on();
    command32(0xec, 0);
    command32(0xe6, 20000000);  // 2000 pulses/s
    command32(0xea, 2000000);   // 20000 pulses/s^2
    command32(0xe9, 2000000);
  }
};

}  // namespace

TEST_CASE("A Tic that has got its supplies is off, in safe start and unsure where it stands") {
  Bench bench;
  CHECK(bench.state() == 2);
  CHECK(bench.errors() == 0x81);
  CHECK(bench.uncertain());
  CHECK(bench.variable(0x33, 2) == 24000);
  bench.command32(0xe0, 100);
  bench.wait(1.0);
  CHECK(bench.position() == 0);
}

TEST_CASE("Energized and out of safe start it obeys within 200 ms, or goes back to safe start") {
  Bench bench;
  bench.switch_on();
  CHECK(bench.state() == 10);
  CHECK(bench.errors() == 0);
  Bench forgetful;
  forgetful.command(0x83);
  forgetful.clock.sleep_for_s(0.25);
  forgetful.command(0x85);
  forgetful.wait(0.05);
  CHECK(forgetful.state() == 4);
  CHECK(forgetful.errors() == 0x80);
}

TEST_CASE("A move takes the time of its trapezoid and ends on its pulse") {
  ReadyBench bench;
  bench.command32(0xe0, 600);
  bench.wait(0.2);
  CHECK(bench.velocity() == 20000000);
  bench.wait(0.15);
  CHECK(bench.position() < 600);
  bench.wait(0.06);  // 600 / 2000 + 2000 / 20000 = 0.4 s
  CHECK(bench.position() == 600);
  CHECK(bench.velocity() == 0);
  CHECK(bench.tic.shaft_pulses() == 600);
  CHECK(bench.seen == 600);
}

TEST_CASE("Unfed for its command timeout it stops in the way that is set") {
  const auto response = GENERATE(1, 2);  // halt and hold, decelerate to hold
  ReadyBench bench;
  bench.tic.store_setting(0x09, 200);
  bench.tic.store_setting(0x0a, 0);
  bench.tic.store_setting(0x53, static_cast<std::uint8_t>(response));
  bench.command32(0xe0, 100000);
  const double sent_s = bench.clock.now_s();
  bench.wait(1.0, false);
  CHECK(bench.errors() == 0xc0);
  CHECK(bench.state() == 4);
  const double ramp_s = response == 1 ? 0.0 : 2000.0 / 20000.0;
  CHECK(bench.tic.last_motion_s() - sent_s == Approx(0.2 + ramp_s).margin(0.01));
  CHECK(bench.uncertain() == (response == 1));
}

TEST_CASE("Brought back from an error it goes on to its last target") {
  ReadyBench bench;
  bench.command32(0xe0, 3000);
  bench.wait(1.2, false);
  const std::int32_t stopped_at = bench.position();
  REQUIRE(stopped_at < 3000);
  bench.switch_on();
  bench.wait(2.0);
  CHECK(bench.position() == 3000);
}

TEST_CASE("A halt is abrupt and makes the position uncertain, a position told makes it certain") {
  ReadyBench bench;
  bench.command32(0xe0, 5000);
  bench.wait(0.5);
  bench.command(0x89);
  const std::int32_t shaft = bench.tic.shaft_pulses();
  bench.wait(0.5);
  CHECK(bench.tic.shaft_pulses() == shaft);
  CHECK(bench.uncertain());
  bench.command32(0xec, -70000);
  CHECK(bench.position() == -70000);
  CHECK_FALSE(bench.uncertain());
  CHECK(bench.tic.shaft_pulses() == shaft);
}

TEST_CASE("A limit switch stops it, blocks its direction and lets it go back") {
  ReadyBench bench;
  bench.tic.place_switches(std::nullopt, 300);
  bench.command32(0xe0, 5000);
  bench.wait(1.0);
  CHECK(bench.position() - 300 <= std::ceil(2000.0 * kStep_s));
  CHECK((bench.variable(0x01, 1) & 4) == 4);
  CHECK(bench.velocity() == 0);
  bench.command32(0xe0, 0);
  bench.wait(1.0);
  CHECK(bench.position() == 0);
}

TEST_CASE("Homing counts from the edge of the switch, wherever the counter stood") {
  ReadyBench bench;
  bench.tic.place_switches(-400, std::nullopt);
  bench.command32(0xec, 12345);
  bench.command(0x97, 0);
  CHECK(bench.homing());
  CHECK(bench.uncertain());
  bench.wait(30.0);
  CHECK_FALSE(bench.homing());
  CHECK_FALSE(bench.uncertain());
  CHECK(bench.position() == 0);
  CHECK(std::abs(bench.tic.shaft_pulses() + 400) <= 1);
}

TEST_CASE("Without power it forgets its position and commands, the shaft stays") {
  ReadyBench bench;
  bench.command32(0xe0, 600);
  bench.wait(1.0);
  bench.tic.power_cycle();
  CHECK(bench.position() == 0);
  CHECK(bench.uncertain());
  CHECK(bench.errors() == 0x81);
  CHECK(bench.tic.shaft_pulses() == 600);
}

TEST_CASE("A low supply and a kill switch stop it and stay reported while they last") {
  ReadyBench bench;
  bench.command32(0xe0, 5000);
  bench.wait(0.5);
  bench.tic.set_supply(3.0);
  const std::int32_t stopped_at = bench.tic.shaft_pulses();
  bench.wait(0.5);
  CHECK((bench.errors() & 4) == 4);
  CHECK(bench.tic.shaft_pulses() == stopped_at);
  bench.tic.set_supply(24.0);
  bench.tic.press_kill_switch(true);
  bench.wait(0.1);
  CHECK((bench.errors() & 0xc) == 8);
  CHECK(bench.state() == 4);
}

TEST_CASE("In another control mode it ignores motion commands without a word") {
  ReadyBench bench;
  bench.tic.store_setting(0x01, 1);
  bench.command32(0xe0, 500);
  bench.wait(1.0);
  CHECK(bench.position() == 0);
  CHECK(bench.tic.targets_received() == 1);
}

TEST_CASE("What it does not know it stalls") {
  Bench bench;
  std::uint8_t data[200]{};
  CHECK(bench.tic.control({0x40, 0x77, 0, 0, 0}, nullptr).status != 0);
  CHECK(bench.tic.control({0xc0, 0xa1, 0, 0, 200}, data).status != 0);
}

}  // namespace planar::test
