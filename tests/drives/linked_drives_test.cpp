#include "planar_servo/hardware/links/linked_drives.h"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <sstream>
#include <string>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "support/link_bench.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using test::make_ready;
using test::Refused;

constexpr DriveLimits kMotor{1000.0, 1000.0};  // it brakes for a second
constexpr int kBeside = 2;

/// What a machine says and does, as the test wants it.
struct Script {
  MachineState state;
  double braking_s{0.0};
  std::function<void(MachineState&)> when_stopped{[](MachineState& told) { told.moving = false; }};
  bool is_gone{false}, refuses{false}, refuses_to_tell{false}, refuses_to_stop{false};
  bool refuses_current{false};
  int moves_told{0};
};

class ScriptedMachine final : public MachineLink {
 public:
  explicit ScriptedMachine(Script& script) : script_(script) {}
  void switch_on() override {
    if (script_.refuses_current) throw MachineRefusal("the door is open", Cause::kDevice);
    script_.state.on = true;
  }
  void go_to(const Pulses&, const std::array<DriveLimits, 3>&) override {
    if (script_.refuses) throw MachineRefusal("the door is open", Cause::kUnreachable);
    ++script_.moves_told;
    script_.state.moving = true;
  }
  void stop() override {
    if (script_.refuses_to_stop) throw WorkError("the brake is worn", Cause::kDevice);
    rests_s_ = clock_.now_s() + script_.braking_s;
  }
  void search_home(int, HomeDirection) override {}
  MachineState read() override {
    if (script_.is_gone) throw WorkError("the cable is cut", Cause::kDevice);
    if (script_.refuses_to_tell) throw MachineRefusal("it went elsewhere", Cause::kContradiction);
    if (clock_.now_s() >= rests_s_) {
      rests_s_ = HUGE_VAL;
      script_.when_stopped(script_.state);
    }
    return script_.state;
  }
  const char* starter() const override { return "its fuse"; }

 private:
  Script& script_;
  SteadyClock clock_;
  double rests_s_{HUGE_VAL};
};

LinkedDrives drives_by(Script& script) {
  return {"the machine",
          {kMotor, kMotor, kMotor},
          [&script] { return std::make_unique<ScriptedMachine>(script); },
          kBeside};
}

TEST_CASE("A halt fails where the machine got out of touch in a move, and not at rest") {
  Script script;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  drives.set_targets({1000, 0, 0});
  script.is_gone = true;
  CHECK_FALSE(drives.status()[0].answers);
  CHECK_THROWS_MATCHES(drives.halt(), DriveError, Refused(Cause::kDevice, "halt"));
  script.is_gone = script.state.moving = false;
  drives.reconnect();
  make_ready(drives);
  script.is_gone = true;
  CHECK_FALSE(drives.status()[0].answers);
  CHECK_NOTHROW(drives.halt());
}

TEST_CASE(
    "A machine that refuses in a move is stopped, and a halt fails where it does not answer") {
  Script script;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  drives.set_targets({1000, 0, 0});
  script.refuses_to_tell = true;
  script.refuses_to_stop = GENERATE(false, true);
  const DriveStatus status = drives.status()[0];
  CHECK_FALSE(status.answers);
  CHECK_FALSE(status.position_certain);
  CHECK(status.faults == std::vector<std::string>{"it went elsewhere"});
  if (script.refuses_to_stop)
    CHECK_THROWS_MATCHES(drives.halt(), DriveError, Refused(Cause::kDevice, "halt"));
  else
    CHECK_NOTHROW(drives.halt());
}

/// Sends the first motor from 0 to 1000, and has it rest at this count.
void rest_on_way(Script& script, LinkedDrives& drives, int count) {
  make_ready(drives);
  drives.set_targets({1000, 0, 0});
  script.state.moving = false;
  script.state.counts[0] = count;
}

TEST_CASE("A machine that has not begun its move is told from one that came to rest on the way") {
  Script script;
  LinkedDrives drives = drives_by(script);
  rest_on_way(script, drives, GENERATE(0, kBeside, 500));
  const DriveStatus status = drives.status()[0];
  REQUIRE(status.faults.size() == 1);
  CHECK_THAT(status.faults[0], Contains("came to rest at"));
  CHECK((status.faults[0].find("it did not begin: look at its fuse; it") == std::string::npos) ==
        (script.state.counts[0] == 500));
}

TEST_CASE("A move that failed is not forgotten by an enable that is refused") {
  Script script;
  LinkedDrives drives = drives_by(script);
  rest_on_way(script, drives, 500);
  REQUIRE(drives.status()[0].faults.size() == 1);
  script.refuses_current = true;
  CHECK_THROWS_MATCHES(drives.energize(), DriveError, Refused(Cause::kDevice, "door"));
  CHECK_THROWS_MATCHES(drives.set_targets({0, 0, 0}), DriveError,
                       Refused(Cause::kDevice, "came to rest at 500"));
  script.refuses_current = false;
  drives.energize();
  CHECK_NOTHROW(drives.set_targets({0, 0, 0}));
}

TEST_CASE("A machine that says that it lost its position is told by its own count of losses") {
  std::ostringstream said;
  const auto usual = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  Script script;
  script.state.losses = 2;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  script.state.losses = 3;
  CHECK_FALSE(drives.status()[0].position_certain);
  spdlog::set_default_logger(usual);
  CHECK_THAT(said.str(), Contains("not certain any more: its losses went from 2 to 3"));
}

TEST_CASE("Counts that change at rest without an order make all positions uncertain") {
  Script script;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  drives.set_targets({700, 0, 0});
  script.state.counts = Pulses(700 + kBeside, 0, 0);
  script.state.moving = false;
  CHECK(drives.status()[1].position_certain);
  script.state.counts = Pulses(700, -kBeside, kBeside);  // a motor that is held gives way
  CHECK(drives.status()[1].position_certain);
  SECTION("of a machine that is on, which is a fault until it is switched on again") {
    script.state.counts = Pulses(0, 0, 0);
    const DriveStatus status = drives.status()[1];
    CHECK_FALSE(status.position_certain);
    REQUIRE(status.faults.size() == 1);
    CHECK_THAT(status.faults[0],
               Contains("stands at 0, 0, 0 counts, where it rested at 702, 0, 0"));
    CHECK_THROWS_MATCHES(drives.set_targets({0, 0, 0}), DriveError,
                         Refused(Cause::kDevice, "702, 0, 0"));
    drives.energize();
    CHECK(drives.status()[1].faults.empty());
    CHECK_FALSE(drives.status()[1].position_certain);
    make_ready(drives);
    CHECK(drives.status()[1].position_certain);
  }
  SECTION("of a machine that is off, and nobody has looked before it is switched on") {
    script.state.on = false;
    script.state.counts = Pulses(0, 0, 0);
    drives.energize();
    CHECK(drives.status()[1].faults.empty());
    CHECK_FALSE(drives.status()[1].position_certain);
    CHECK_THROWS_MATCHES(drives.set_targets({0, 0, 0}), DriveError,
                         Refused(Cause::kDevice, "drive 1"));
  }
}

TEST_CASE("A place beyond 32 bits of the machine's counts is refused, and no other taken for it") {
  Script script;
  constexpr int kMost = std::numeric_limits<int>::max();
  script.state.counts = Pulses(kMost - 500, -1, 0);
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  CHECK_THROWS_MATCHES(drives.set_targets({1000, 0, 0}), DriveError,
                       Refused(Cause::kUnreachable, "drive 1 would count 2147484147"));
  CHECK(script.moves_told == 0);
  CHECK_THROWS_MATCHES(drives.set_position(0, -1000), DriveError,
                       Refused(Cause::kUnreachable, "drive 1"));
  CHECK(drives.status()[0].position_certain);
  script.state.counts[1] = kMost;  // so far from where it rested that the difference is no int
  CHECK_FALSE(drives.status()[1].position_certain);
}

TEST_CASE("A machine that is out of touch stands nowhere") {
  Script script;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  TransmissionSettings settings;
  for (auto& motor : settings.drives) motor = {1000.0, 1.0, 1, 1.0, 1.0};
  settings.limits_rad.fill({-1.0, 1.0});
  SteadyClock clock;
  PlanarRobot robot(PlanarArm({{0.3, 0.25}, Rotation::kClockwise}), Transmission(settings), drives,
                    clock);
  CHECK(robot.known_pulses() == Pulses(0, 0, 0));
  script.is_gone = true;
  CHECK_THROWS_AS(robot.present_joints(), DriveError);
  CHECK_FALSE(robot.known_pulses());
}

TEST_CASE("A machine that moves unasked is uncertain, also when it is switched on meanwhile") {
  Script script;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  const bool is_seen = GENERATE(true, false);
  script.state.moving = true;
  script.state.counts = Pulses(0, 3 * kBeside, 0);
  if (is_seen) CHECK_FALSE(drives.status()[0].position_certain);
  drives.energize();  // which stops it
  CHECK_FALSE(script.state.moving);
  CHECK_FALSE(drives.status()[0].position_certain);
}

TEST_CASE(
    "A machine that is off unprompted, or comes back in emergency stop, was stopped by hand") {
  Script script;
  LinkedDrives drives = drives_by(script);
  script.state.emergency = true;  // before it was ever switched on
  CHECK_FALSE(drives.status()[0].stopped_by_hand);
  make_ready(drives);
  CHECK_FALSE(drives.status()[0].stopped_by_hand);
  script.state.on = false;
  CHECK(drives.status()[0].stopped_by_hand);
  drives.energize();
  script.is_gone = true;
  CHECK_FALSE(drives.status()[0].answers);
  script.is_gone = script.state.on = false;
  drives.reconnect();
  CHECK(drives.status()[0].stopped_by_hand);
  CHECK_THAT(drives.status()[0].faults.front(), Contains("emergency stop"));
  drives.energize();
  CHECK_FALSE(drives.status()[0].stopped_by_hand);
  script.state.emergency = false;
  script.state.on = false;
  script.state.faults = {"alarm 7, which may be the emergency stop"};
  CHECK(drives.status()[0].stopped_by_hand);
  script.state.faults.clear();
  drives.energize();
  script.is_gone = true;
  CHECK_FALSE(drives.status()[0].answers);
  script.is_gone = false;
  SECTION("as where its power was cut") {
    script.state.on = false;
    drives.reconnect();
    CHECK(drives.status()[0].stopped_by_hand);
    CHECK_THAT(drives.status()[0].faults.front(), Contains("its power was cut"));
  }
  SECTION("and not where only the link was lost") {
    drives.reconnect();
    CHECK_FALSE(drives.status()[0].stopped_by_hand);
  }
}

TEST_CASE("A move that a machine refuses costs no position") {
  Script script;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  script.refuses = true;
  CHECK_THROWS_MATCHES(drives.set_targets({1000, 0, 0}), DriveError,
                       Refused(Cause::kUnreachable, "the door"));
  CHECK_FALSE(drives.status()[0].stopped_by_hand);
  drives.halt();
  CHECK(drives.status()[0].position_certain);
  script.refuses = false;
  drives.set_targets({1000, 0, 0});
  CHECK(script.moves_told == 1);
}

TEST_CASE("A machine that loses its position or fails as it brakes is not sent on") {
  const bool loses = GENERATE(true, false);
  Script script;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  drives.set_targets({1000, 0, 0});
  script.when_stopped = [loses](MachineState& told) {
    told.moving = false;
    if (loses) ++told.losses;
    if (!loses) told.faults.emplace_back("motor 2 is hot");
  };
  CHECK_THROWS_MATCHES(drives.set_targets({500, 0, 0}), DriveError,
                       Refused(Cause::kDevice, loses ? "drive 1" : "motor 2"));
  CHECK(script.moves_told == 1);
}

TEST_CASE("A machine may brake for as long as its limits let it, and a while longer") {
  Script script;
  LinkedDrives drives = drives_by(script);
  make_ready(drives);
  drives.set_targets({1000, 0, 0});
  script.braking_s = 2.3;
  CHECK_NOTHROW(drives.halt());
  CHECK(drives.status()[0].position_certain);
}

}  // namespace
}  // namespace planar
