#include <catch2/catch.hpp>
#include <functional>
#include <thread>

#include "planar_servo/base/core/units.h"
#include "planar_servo/hardware/drives/tic_drives.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "support/eventually.h"
#include "support/refused.h"
#include "support/tic_bench.h"

namespace planar {
namespace {

using test::eventually;
using test::Refused;
using test::TicBench;
using test::UsbFault;

constexpr double kPatience_s = 10.0;
constexpr double kPulsesPerRad = 2000.0;
const Joints kNear{0.1, 0.1, 0.1};
/// A second of travel: long enough to fail on the way.
const Joints kFar{1.9, 1.9, 1.9};

TransmissionSettings transmission_settings() {
  TransmissionSettings settings;
  settings.coupling = {Coupling::kAbsolute, Coupling::kAbsolute};
  for (auto& drive : settings.drives) {
    drive = {kPulsesPerRad * 2.0 * kPi, 1.0, 1, 2.0, 200.0};
    drive.home = HomeReference::kReverseSwitch;
    drive.home_rad = TicBench::kReverseSwitch_pulses / kPulsesPerRad;
  }
  settings.limits_rad.fill({-0.4, 1.95});
  return settings;
}

/// A robot on three Tics, homed by being taught where it stands.
struct RobotBench : TicBench {
  explicit RobotBench(double command_timeout_s = 2.0)
      : TicBench(command_timeout_s), drives(settings) {
    robot.energize();
    for (int i = 0; i < 3; ++i) drives.set_position(i, 0);
  }

  /// What the robot says when `fault` happens on its way.
  WorkError failure_of_move(const std::function<void()>& fault) {
    std::thread cause([&] {
      eventually([&] { return tics[1].shaft_pulses() > 200; });
      fault();
    });
    WorkError failure("", Cause::kInvalid);
    try {
      robot.move_to(kFar);
    } catch (const DriveError& error) {
      failure = WorkError(error.refusal());
    }
    cause.join();
    return failure;
  }

  bool nothing_turns() {
    std::array<std::int32_t, 3> before{};
    for (std::size_t i = 0; i < 3; ++i) before[i] = tics[i].shaft_pulses();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    for (std::size_t i = 0; i < 3; ++i)
      if (tics[i].shaft_pulses() != before[i]) return false;
    return true;
  }

  int targets_received() {
    return tics[0].targets_received() + tics[1].targets_received() + tics[2].targets_received();
  }

  /// Work continues: nothing moves before those that lost their position are homed.
  void check_recovery(bool by_hand = false) {
    if (by_hand) CHECK_THROWS_AS(robot.recover(kPatience_s), StoppedByHand);
    by_hand ? robot.switch_on() : robot.recover(kPatience_s);
    CHECK(nothing_turns());
    if (!robot.unhomed().empty())
      CHECK_THROWS_MATCHES(robot.move_to(kNear), DriveError, Refused(Cause::kDevice, "position"));
    CHECK(nothing_turns());
    for (const int joint : robot.unhomed()) robot.search_home(joint);
    robot.move_to(kNear);
    for (auto& tic : tics) CHECK(std::abs(tic.shaft_pulses() - 200) <= 1);
  }

  TicDrives drives;
  PlanarRobot robot{PlanarArm({{0.3, 0.3}, Rotation::kCounterclockwise}),
                    Transmission(transmission_settings()), drives, clock};
};

}  // namespace

TEST_CASE("An unplugged drive stops the others, and is found again when it is plugged in") {
  RobotBench bench(0.3);
  const WorkError failure = bench.failure_of_move([&] { bench.devices[1].unplug(); });
  for (const char* name : {"drive 2 failed", "drive 2 (00422222)", "300 ms"})
    CHECK_THAT(failure, Refused(Cause::kDevice, name));
  CHECK(eventually([&] { return bench.nothing_turns(); }));
  const int targets = bench.targets_received();
  CHECK_THROWS_MATCHES(bench.robot.move_to(kNear), DriveError, Refused(Cause::kDevice, "drive 2"));
  CHECK_THROWS_MATCHES(bench.robot.recover(0.2), DriveError, Refused(Cause::kDevice, "'00422222'"));
  CHECK(bench.targets_received() == targets);
  bench.devices[1].plug();
  bench.check_recovery();
}

TEST_CASE("A stalled, failed or short transfer halts all drives") {
  const auto kind =
      GENERATE(UsbFault::Kind::kStall, UsbFault::Kind::kIoError, UsbFault::Kind::kShort);
  RobotBench bench;
  CHECK_THAT(bench.failure_of_move([&] {
    bench.devices[1].inject({kind, 1, std::uint8_t{0xa1}});
  }),
             Refused(Cause::kDevice, "drive 2"));
  CHECK(bench.nothing_turns());
  bench.check_recovery();
}

TEST_CASE("An answer that comes too late, or never, halts all drives") {
  const auto kind = GENERATE(UsbFault::Kind::kLate, UsbFault::Kind::kSilence);
  RobotBench bench(0.4);
  UsbFault fault{kind, 1, std::uint8_t{0xa1}};
  fault.late_s = 1.0;
  CHECK_THAT(bench.failure_of_move([&] { bench.devices[1].inject(fault); }),
             Refused(Cause::kDevice, "200 ms"));
  CHECK(bench.nothing_turns());
  bench.check_recovery();
}

TEST_CASE("A drive that falls silent altogether stops by its own command timeout") {
  RobotBench bench(0.3);
  CHECK_THAT(bench.failure_of_move([&] {
    bench.devices[1].inject({UsbFault::Kind::kSilence, -1});
  }),
             Refused(Cause::kDevice, "drive 2 (00422222)"));
  CHECK(eventually([&] { return bench.nothing_turns(); }));
  bench.devices[1].clear_fault();
  bench.check_recovery();
}

TEST_CASE("A limit switch on the way halts all drives") {
  RobotBench bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.tics[1].place_switches(-1000, 600); }),
             Refused(Cause::kDevice, "forward limit switch"));
  CHECK(bench.nothing_turns());
  bench.tics[1].place_switches(TicBench::kReverseSwitch_pulses, TicBench::kForwardSwitch_pulses);
  bench.check_recovery();
}

TEST_CASE("A low supply and a kill switch halt all drives until they are gone") {
  RobotBench bench;
  CHECK_THAT(bench.failure_of_move([&] { bench.tics[1].set_supply(3.0); }),
             Refused(Cause::kStopped, "low supply"));
  CHECK(bench.nothing_turns());
  CHECK_THROWS_MATCHES(bench.robot.recover(0.2), StoppedByHand,
                       Refused(Cause::kStopped, "low supply"));
  bench.tics[1].set_supply(24.0);
  bench.check_recovery(true);
  CHECK_THAT(bench.failure_of_move([&] { bench.tics[2].press_kill_switch(true); }),
             Refused(Cause::kStopped, "kill switch"));
  CHECK(bench.nothing_turns());
  CHECK_THROWS_AS(bench.robot.move_to(kNear), StoppedByHand);
  bench.tics[2].press_kill_switch(false);
  bench.check_recovery(true);
}

TEST_CASE("A kill switch that nobody saw pressed stops the arm until a person switches it on") {
  RobotBench bench;
  bench.robot.move_to(kNear);
  bench.tics[2].press_kill_switch(true);
  bench.tics[2].press_kill_switch(false);
  CHECK_THROWS_MATCHES(bench.robot.recover(kPatience_s), StoppedByHand,
                       Refused(Cause::kStopped, "kill switch active for a moment"));
  bench.check_recovery(true);
}

TEST_CASE("A drive that had no power for a moment has to be homed, the others keep their place") {
  RobotBench bench;
  bench.robot.move_to(kNear);
  bench.tics[1].power_cycle();
  CHECK_THROWS_MATCHES(bench.robot.move_to(kFar), DriveError, Refused(Cause::kDevice, "drive 2"));
  bench.robot.recover(kPatience_s);
  CHECK(bench.robot.unhomed() == std::vector<int>{1});
  bench.check_recovery();
}

TEST_CASE("Drives that change their sockets stay the drives of their joints") {
  RobotBench bench;
  bench.devices[0].unplug();
  bench.devices[1].unplug();
  CHECK_THROWS_AS(bench.robot.move_to(kNear), DriveError);
  bench.devices[1].plug();
  bench.devices[0].plug();
  bench.robot.recover(kPatience_s);
  for (const int joint : bench.robot.unhomed()) bench.robot.search_home(joint);
  bench.robot.move_to({0.1, 0.2, 0.3});
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(std::abs(bench.tics[i].shaft_pulses() - 200 * (static_cast<int>(i) + 1)) <= 1);
}

}  // namespace planar
