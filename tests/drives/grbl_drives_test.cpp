#include "planar_servo/hardware/drives/grbl_drives.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <random>
#include <thread>

#include "planar_servo/hardware/drives/drive_kinds.h"
#include "support/eventually.h"
#include "support/grbl_bench.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using test::eventually;
using test::GrblBench;
using test::Refused;
using Targets = std::array<std::int32_t, 3>;

bool all_rest(GrblDrives& drives) {
  return eventually([&] { return !drives.status()[0].moving; });
}

Targets positions(GrblDrives& drives) {
  const auto status = drives.status();
  return {status[0].position_pulses, status[1].position_pulses, status[2].position_pulses};
}

/// A board that is switched on and knows where it stands: at 0.
struct ReadyBench : GrblBench {
  ReadyBench() : drives(settings) {
    drives.energize();
    for (int i = 0; i < 3; ++i) drives.set_position(i, 0);
  }
  GrblDrives drives;
};

TEST_CASE("A board is opened, switched on and homed before it is trusted") {
  GrblBench bench;
  GrblDrives drives(bench.settings);
  CHECK_THROWS_MATCHES(drives.set_targets({1, 1, 1}), DriveError,
                       Refused(Cause::kDevice, "switched"));
  CHECK_FALSE(drives.status()[0].energized);
  drives.energize();
  for (const DriveStatus& status : drives.status()) {
    CHECK(status.energized);
    CHECK_FALSE(status.position_certain);
    CHECK(status.faults.empty());
  }
  drives.set_position(1, -70);
  CHECK(drives.status()[1].position_certain);
  CHECK(drives.status()[1].position_pulses == -70);
  CHECK(bench.board.shafts() == EmulatedGrbl::Pulses(0, 0, 0));
}

TEST_CASE("A board whose position was forgotten at rest is uncertain until it is told again") {
  ReadyBench bench;
  bench.drives.forget_positions();
  for (const DriveStatus& status : bench.drives.status()) CHECK_FALSE(status.position_certain);
  bench.drives.set_position(1, 0);
  CHECK(bench.drives.status()[1].position_certain);
}

TEST_CASE("Each joint moves its own axis, counted from where it was said to stand") {
  ReadyBench bench;
  bench.drives.set_position(1, 1000);
  bench.drives.set_targets({300, 900, -50});
  CHECK(bench.drives.status()[0].moving);
  CHECK(bench.drives.status()[1].target_pulses == 900);
  REQUIRE(all_rest(bench.drives));
  CHECK(positions(bench.drives) == Targets{300, 900, -50});
  CHECK(bench.board.shafts() == EmulatedGrbl::Pulses(300, -50, -100));
}

TEST_CASE("Pulses made equal pulses commanded after many random moves") {
  ReadyBench bench;
  std::mt19937 random(11);
  std::uniform_int_distribution<int> pulses(-300, 300);
  for (int i = 0; i < 30; ++i) {
    const Targets targets{pulses(random), pulses(random), pulses(random)};
    bench.drives.set_targets(targets);
    REQUIRE(all_rest(bench.drives));
    REQUIRE(positions(bench.drives) == targets);
    REQUIRE(bench.board.shafts() == EmulatedGrbl::Pulses(targets[0], targets[2], targets[1]));
  }
}

TEST_CASE("A caller that goes silent lets the arm rest soon, with its positions certain") {
  ReadyBench bench;
  bench.drives.set_targets({40000, 0, 0});
  REQUIRE(eventually([&] { return bench.drives.status()[0].position_pulses > 1000; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  const int here = bench.board.shafts().x();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  CHECK(bench.board.shafts().x() == here);
  CHECK(here < 39000);
  CHECK(bench.drives.status()[0].position_certain);
  CHECK(bench.drives.status()[0].position_pulses == here);
}

TEST_CASE("A move begins with its command, not with the next question") {
  ReadyBench bench;
  for (const int target : {100, 0}) {
    bench.drives.set_targets({target, 0, 0});
    CHECK(eventually([&] { return bench.board.shafts().x() == target; }));
    REQUIRE(all_rest(bench.drives));
  }
}

TEST_CASE("A new target ahead is reached without a stop, one behind after braking") {
  ReadyBench bench;
  bench.drives.set_targets({3000, 0, 0});
  REQUIRE(eventually([&] { return bench.drives.status()[0].position_pulses > 1000; }));
  bench.drives.set_targets({5000, 700, 0});
  REQUIRE(all_rest(bench.drives));
  CHECK(positions(bench.drives) == Targets{5000, 700, 0});
  CHECK(bench.board.last_cancel_s() == 0.0);
  bench.drives.set_targets({15000, 700, 0});
  REQUIRE(eventually([&] { return bench.drives.status()[0].position_pulses > 7000; }));
  bench.drives.set_targets({6000, 0, 0});
  CHECK(bench.drives.status()[0].moving);
  REQUIRE(all_rest(bench.drives));
  CHECK(bench.board.last_cancel_s() > 0.0);
  CHECK(positions(bench.drives) == Targets{6000, 0, 0});
}

TEST_CASE("A halt brakes to rest and keeps the positions") {
  ReadyBench bench;
  bench.drives.set_targets({40000, 0, 100});
  REQUIRE(eventually([&] { return bench.drives.status()[0].position_pulses > 1000; }));
  bench.drives.halt();
  const auto status = bench.drives.status();
  CHECK_FALSE(status[0].moving);
  CHECK(status[0].position_certain);
  CHECK(status[0].faults.empty());
  CHECK(status[0].position_pulses == bench.board.shafts().x());
  CHECK(status[0].position_pulses < 10000);
}

TEST_CASE("Lower speeds are kept, and limits beyond the cell's refused") {
  ReadyBench bench;
  CHECK_THROWS_MATCHES(
      bench.drives.set_limits({DriveLimits{9000.0, 40000.0}, {1.0, 1.0}, {1.0, 1.0}}), InputError,
      Refused(Cause::kInvalid, "9000 pulses/s"));
  bench.drives.set_limits({DriveLimits{400.0, 40000.0}, {400.0, 400.0}, {400.0, 400.0}});
  bench.drives.set_targets({200, 0, 0});
  REQUIRE(all_rest(bench.drives));
  CHECK_THAT(bench.board.last_jog(), Contains("X0.800") && Contains("F96.000"));
}

TEST_CASE("Targets so far off that Grbl would lose pulses are refused") {
  ReadyBench bench;
  CHECK_THROWS_MATCHES(bench.drives.set_targets({3000000, 0, 0}), DriveError,
                       Refused(Cause::kUnreachable, "3000000 pulses"));
  CHECK(bench.board.last_jog().empty());
}

TEST_CASE("One search finds the switches of all joints, each of which is then homed") {
  GrblBench bench(HomeReference::kReverseSwitch);
  GrblDrives drives(bench.settings);
  drives.energize();
  drives.start_homing(1, HomeDirection::kReverse);
  CHECK(drives.status()[1].homing);
  REQUIRE(eventually([&] { return !drives.status()[1].homing; }));
  CHECK(drives.status()[1].position_certain);
  CHECK(drives.status()[1].position_pulses == 0);
  CHECK_FALSE(drives.status()[0].position_certain);
  const auto found = bench.board.shafts();
  CHECK(found == EmulatedGrbl::Pulses(-1000, -2000, -500));
  drives.start_homing(0, HomeDirection::kReverse);
  CHECK(drives.status()[0].position_certain);
  CHECK(bench.board.shafts() == found);
  drives.set_position(2, 700);  // from now on it is not counted from its switch
  drives.start_homing(2, HomeDirection::kReverse);
  CHECK(drives.status()[2].homing);
  REQUIRE(eventually([&] { return !drives.status()[2].homing; }));
  CHECK(drives.status()[2].position_pulses == 0);
}

TEST_CASE("A search that is halted ends at once, and nothing is certain") {
  GrblBench bench(HomeReference::kForwardSwitch);
  bench.board.place_switches(Eigen::Vector3d(1000.0, 1000.0, 1000.0));
  GrblDrives drives(bench.settings);
  drives.energize();
  drives.start_homing(0, HomeDirection::kForward);
  REQUIRE(eventually([&] { return bench.board.shafts().x() > 100; }));
  drives.halt();
  const auto here = bench.board.shafts();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK(bench.board.shafts() == here);
  CHECK_FALSE(drives.status()[0].homing);
  CHECK_FALSE(drives.status()[0].position_certain);
}

TEST_CASE("A search that finds no switch says so") {
  GrblBench bench(HomeReference::kForwardSwitch);
  GrblDrives drives(bench.settings);
  bench.board.place_switches(std::nullopt);
  drives.energize();
  drives.start_homing(2, HomeDirection::kForward);
  REQUIRE(eventually([&] { return !drives.status()[2].homing; }));
  const std::vector<std::string> faults = drives.status()[0].faults;
  CHECK_THAT(faults.at(0), Contains("alarm 9: no home switch was found"));
  CHECK(std::find(faults.begin(), faults.end(), "it was reset, or lost power for a moment") ==
        faults.end());
  CHECK_FALSE(drives.status()[2].position_certain);
  CHECK_FALSE(drives.status()[2].moving);
}

TEST_CASE("A board whose settings differ is not opened and does not move") {
  GrblBench bench;
  bench.board.set(100, 80.0);
  CHECK_THROWS_MATCHES(GrblDrives(bench.settings), DriveError,
                       Refused(Cause::kContradiction, "$100 is 80"));
  CHECK(bench.board.last_jog().empty());
}

TEST_CASE("Two programs do not share a port") {
  ReadyBench bench;
  CHECK_THROWS_MATCHES(GrblDrives(bench.settings), DriveError,
                       Refused(Cause::kBusy, bench.settings.port));
}

TEST_CASE("A program that reads the port, whatever locks it heeds, is named") {
  GrblBench bench;
  const test::PortReader cat(bench.settings.port);
  CHECK_THROWS_MATCHES(GrblDrives(bench.settings), DriveError, Refused(Cause::kBusy, cat.name()));
}

TEST_CASE("A board that starts slowly, and says so, is waited for") {
  GrblBench bench;
  bench.board.be_silent(true);
  std::thread board([&] {
    for (int i = 0; i < 12; ++i) {
      bench.board.say("ets Jun  8 2016 00:22:57\r\n\r\nrst:0x1 (POWERON_RESET),boot:0x13\r\n");
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
    bench.board.be_silent(false);
  });
  CHECK_NOTHROW(GrblDrives(bench.settings));
  board.join();
}

TEST_CASE("A board that talks and never tells its settings is not waited for without end") {
  GrblBench bench;
  bench.board.be_silent(true);
  std::atomic<bool> ending{false};
  std::thread board([&] {
    for (int i = 0; !ending; ++i) {
      const bool greets = i < 100 && i % 20 == 0;
      bench.board.say(greets ? "Grbl 1.1h ['$' for help]\r\n" : "[MSG:Caution]\r\n");
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  CHECK_THROWS_MATCHES(GrblDrives(bench.settings), DriveError, Refused(Cause::kDevice, "settings"));
  ending = true;
  board.join();
}

TEST_CASE("A board with other firmware is named, whether it greets or must be asked") {
  GrblBench bench;
  bench.board.be_silent(true);
  std::atomic<bool> ending{false};
  std::thread board([&] {
    while (!ending) {
      bench.board.say(
          "FIRMWARE_NAME:Marlin 2.1.2 (Dec 17 2022) SOURCE_CODE_URL:github.com\r\nok\r\n");
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  });
  CHECK_THROWS_MATCHES(GrblDrives(bench.settings), DriveError, Refused(Cause::kForeign, "Marlin"));
  ending = true;
  board.join();
}

TEST_CASE("A port that is absent, silent or not a board's is refused with the remedy") {
  GrblBench bench;
  GrblSettings absent = bench.settings;
  absent.port = "/dev/serial/by-id/none";
  CHECK_THROWS_MATCHES(GrblDrives(absent), DriveError, Refused(Cause::kMissing, absent.port));
  GrblSettings file = bench.settings;
  file.port = bench.folder.write("file", "").string();
  CHECK_THROWS_MATCHES(GrblDrives(file), DriveError, Refused(Cause::kSystem, file.port));
  bench.board.be_silent(true);
  CHECK_THROWS_MATCHES(GrblDrives(bench.settings), DriveError,
                       Refused(Cause::kDevice, "115200 baud"));
}

TEST_CASE("The doctor tells a well board from one that differs or is absent") {
  GrblBench bench;
  CHECK(examine_grbl(bench.settings).at(0).verdict == Finding::Verdict::kWell);
  CHECK_THAT(examine_grbl(bench.settings).at(0).fault, Contains("Grbl 1.1h"));
  bench.board.press_limit('Y', true);
  bench.board.press_limit('P', true);  // a probe stops nothing
  const std::vector<Finding> pressed = examine_grbl(bench.settings);
  REQUIRE(pressed.size() == 2);
  CHECK(pressed[1].verdict == Finding::Verdict::kDoubtful);
  CHECK(pressed[1].fault == "inputs are on at rest: limit Y");
  CHECK_THAT(pressed[1].remedy, Contains("$5"));
  bench.board.press_limit('R', true);
  CHECK(examine_grbl(bench.settings).at(1).fault == "inputs are on at rest: limit Y, reset");
  bench.board.set(120, 10.0);
  CHECK(examine_grbl(bench.settings).at(0).verdict == Finding::Verdict::kFaulty);
  CHECK_THAT(examine_grbl(bench.settings).at(0).remedy, Contains("$120=160"));
  bench.board.unplug();
  CHECK(examine_grbl(bench.settings).at(0).cause == Cause::kMissing);
}

TEST_CASE("FluidNC is told by its name, and its settings by their paths") {
  GrblBench bench(HomeReference::kReverseSwitch);
  bench.board.be_fluidnc();
  SECTION("and moves as Grbl does") {
    GrblDrives drives(bench.settings);
    drives.energize();
    drives.start_homing(0, HomeDirection::kReverse);
    REQUIRE(eventually([&] { return !drives.status()[0].homing; }));
    CHECK(drives.status()[0].position_certain);
    for (int i = 1; i < 3; ++i) drives.set_position(i, 0);
    drives.set_targets({500, 250, -250});
    REQUIRE(all_rest(drives));
    CHECK(positions(drives) == Targets{500, 250, -250});
  }
  SECTION("and is refused where these differ, by what mends them") {
    bench.board.set(101, 80);
    bench.board.set(1, 25);
    bench.board.set(23, 5);
    CHECK_THROWS_WITH(GrblDrives(bench.settings),
                      Contains("FluidNC v3.7.12") && Contains("$/axes/y/steps_per_mm=250") &&
                          Contains("$/stepping/idle_ms=255") &&
                          Contains("$/axes/y/homing/positive_direction=false"));
  }
}

}  // namespace
}  // namespace planar
