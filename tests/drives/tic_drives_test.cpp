#include "planar_servo/hardware/drives/tic_drives.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>

#include "support/eventually.h"
#include "support/refused.h"
#include "support/tic_bench.h"

namespace planar {
namespace {

using Catch::Contains;
using test::EmulatedTic;
using test::eventually;
using test::MockUsbDevice;
using test::Refused;
using test::TicBench;

constexpr double kShortTimeout_s = 0.2;

void sleep_s(double duration_s) {
  std::this_thread::sleep_for(std::chrono::duration<double>(duration_s));
}

bool at_rest_at(TicDrives& drives, const std::array<std::int32_t, 3>& pulses) {
  const auto status = drives.status();
  for (std::size_t i = 0; i < 3; ++i)
    if (status[i].moving || status[i].position_pulses != pulses[i]) return false;
  return true;
}

/// Drives that are on and believe to stand at 0.
struct ReadyDrives {
  explicit ReadyDrives(TicBench& bench) : drives(bench.settings) {
    drives.set_limits({TicBench::kLimits, TicBench::kLimits, TicBench::kLimits});
    drives.energize();
    for (int i = 0; i < 3; ++i) drives.set_position(i, 0);
  }
  TicDrives drives;
};

}  // namespace

TEST_CASE("Opened, a Tic has the command timeout and halts and holds when it passes") {
  TicBench bench(0.25);
  const TicDrives drives(bench.settings);
  for (EmulatedTic& tic : bench.tics) {
    CHECK(tic.setting(0x09) == 250);
    CHECK(tic.setting(0x0a) == 0);
    CHECK(tic.setting(0x53) == 1);
  }
}

TEST_CASE("Drives that cannot be used are all named, with what mends them") {
  TicBench bench;
  bench.settings[0].serial = "00499999";
  bench.tics[1].store_setting(0x01, 1);
  bench.tics[2].store_setting(0x03, 1);
  CHECK_THROWS_WITH(TicDrives(bench.settings),
                    Contains("drive 1 (00499999): no Tic") && Contains("00422222, 00411111") &&
                        Contains("drive 2 (00422222): its control mode is 1") &&
                        Contains("drive 3 (00433333): its safe start"));
  CHECK_THROWS_MATCHES(TicDrives(bench.settings), DriveError, Refused(Cause::kDevice));
  for (std::size_t i = 1; i < 3; ++i) bench.settings[i].serial = "0049999" + std::to_string(i);
  CHECK_THROWS_MATCHES(TicDrives(bench.settings), DriveError,
                       Refused(Cause::kMissing, "drive 3 (00499992): no Tic"));
}

TEST_CASE("Firmware that cannot search for a switch is refused") {
  TicBench bench;
  bench.devices[1].unplug();
  MockUsbDevice old(bench.bus, EmulatedTic::description("00400001", 0x00cb, 0x0105), bench.tics[1]);
  bench.settings[1].serial = "00400001";
  CHECK_THROWS_MATCHES(TicDrives(bench.settings), DriveError,
                       Refused(Cause::kForeign, "firmware 1.05"));
}

TEST_CASE("Two joints cannot have the same drive") {
  TicBench bench;
  bench.settings[2].serial = bench.settings[0].serial;
  CHECK_THROWS_AS(TicDrives(bench.settings), std::invalid_argument);
}

TEST_CASE("Nothing moves and nothing is on until it is asked for") {
  TicBench bench;
  TicDrives drives(bench.settings);
  for (const DriveStatus& status : drives.status()) {
    CHECK(status.answers);
    CHECK_FALSE(status.energized);
    CHECK_FALSE(status.moving);
    CHECK_FALSE(status.position_certain);
  }
  CHECK_THROWS_MATCHES(drives.set_targets({1, 2, 3}), DriveError,
                       Refused(Cause::kDevice, "switched"));
  for (EmulatedTic& tic : bench.tics) CHECK(tic.targets_received() == 0);
}

TEST_CASE("All three drives go to their targets") {
  TicBench bench;
  ReadyDrives ready(bench);
  ready.drives.set_targets({300, -500, 900});
  CHECK(ready.drives.status()[2].moving);
  CHECK(eventually([&] { return at_rest_at(ready.drives, {300, -500, 900}); }));
  CHECK(bench.tics[1].shaft_pulses() == -500);
}

TEST_CASE("The serial number decides which joint a drive turns, not the socket") {
  TicBench bench;
  for (MockUsbDevice& device : bench.devices) device.unplug();
  for (const std::size_t i : {2U, 0U, 1U}) bench.devices[i].plug();
  ReadyDrives ready(bench);
  ready.drives.set_targets({100, 200, 300});
  CHECK(eventually([&] { return at_rest_at(ready.drives, {100, 200, 300}); }));
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(bench.tics[i].shaft_pulses() == 100 * (static_cast<int>(i) + 1));
}

TEST_CASE("Limits that no Tic can keep are refused") {
  TicBench bench;
  TicDrives drives(bench.settings);
  CHECK_THROWS_AS(drives.set_limits({TicBench::kLimits, {60e3, 1e5}, TicBench::kLimits}),
                  InputError);
}

TEST_CASE("A home search ends at the edge of the switch, certain of its position") {
  TicBench bench;
  ReadyDrives ready(bench);
  const auto direction = GENERATE(HomeDirection::kReverse, HomeDirection::kForward);
  const std::int32_t edge = direction == HomeDirection::kForward ? TicBench::kForwardSwitch_pulses
                                                                 : TicBench::kReverseSwitch_pulses;
  ready.drives.start_homing(1, direction);
  CHECK_FALSE(ready.drives.status()[1].position_certain);
  CHECK(eventually([&] { return !ready.drives.status()[1].homing; }));
  const DriveStatus found = ready.drives.status()[1];
  CHECK(found.position_certain);
  CHECK(found.position_pulses == 0);
  CHECK(std::abs(bench.tics[1].shaft_pulses() - edge) <= 1);
  ready.drives.set_position(1, 7000);
  CHECK(ready.drives.status()[1].position_pulses == 7000);
}

TEST_CASE("Without a pin for the switch no search begins") {
  TicBench bench;
  ReadyDrives ready(bench);
  bench.tics[0].place_switches(std::nullopt, std::nullopt);
  CHECK_THROWS_MATCHES(ready.drives.start_homing(0, HomeDirection::kForward), DriveError,
                       Refused(Cause::kMissing, "forward"));
  CHECK_FALSE(ready.drives.status()[0].moving);
}

TEST_CASE("A halt stops what moves at once and leaves what rests in certainty") {
  TicBench bench;
  ReadyDrives ready(bench);
  ready.drives.set_targets({3000, 0, 0});
  CHECK(eventually([&] { return ready.drives.status()[0].position_pulses > 100; }));
  ready.drives.halt();
  const std::int32_t stopped_at = bench.tics[0].shaft_pulses();
  sleep_s(0.05);
  CHECK(bench.tics[0].shaft_pulses() == stopped_at);
  const auto status = ready.drives.status();
  CHECK_FALSE(status[0].position_certain);
  CHECK(status[1].position_certain);
}

TEST_CASE("At rest the drives are fed, without anybody asking for their status") {
  TicBench bench(kShortTimeout_s);
  ReadyDrives ready(bench);
  sleep_s(4 * kShortTimeout_s);
  for (const DriveStatus& status : ready.drives.status()) {
    CHECK(status.faults.empty());
    CHECK(status.position_certain);
  }
}

TEST_CASE("A drive whose caller falls silent while it moves stops by itself and says so") {
  TicBench bench(kShortTimeout_s);
  ReadyDrives ready(bench);
  ready.drives.set_targets({3900, 0, 0});
  sleep_s(3 * kShortTimeout_s);
  const std::int32_t stopped_at = bench.tics[0].shaft_pulses();
  CHECK(stopped_at > 0);
  CHECK(stopped_at < 3900);
  const auto status = ready.drives.status();
  CHECK(status[0].faults.at(0) == "command timeout");
  CHECK(status[1].faults.empty());
}

TEST_CASE("A drive that was stopped does not resume its old move when it is switched on again") {
  TicBench bench(kShortTimeout_s);
  ReadyDrives ready(bench);
  ready.drives.set_targets({3900, 0, 0});
  sleep_s(3 * kShortTimeout_s);
  const std::int32_t stopped_at = bench.tics[0].shaft_pulses();
  ready.drives.energize();
  CHECK(ready.drives.status()[0].energized);
  sleep_s(kShortTimeout_s);
  CHECK(bench.tics[0].shaft_pulses() == stopped_at);
}

TEST_CASE("A drive that does not tell where it stands is not switched on: it would go elsewhere") {
  TicBench bench;
  ReadyDrives ready(bench);
  ready.drives.set_targets({3900, 0, 0});
  CHECK(eventually([&] { return ready.drives.status()[0].position_pulses > 100; }));
  sleep_s(0.1);
  ready.drives.halt();
  const std::int32_t stopped_at = bench.tics[0].shaft_pulses();
  bench.devices[0].inject({test::UsbFault::Kind::kStall});
  CHECK_THROWS_MATCHES(ready.drives.energize(), DriveError,
                       Refused(Cause::kDevice, "drive 1 (00411111) cannot be told to switch on"));
  sleep_s(0.2);
  CHECK(bench.tics[0].shaft_pulses() == stopped_at);
}

TEST_CASE("A stop by hand before the program began does not count") {
  TicBench bench;
  { const TicDrives before(bench.settings); }
  bench.tics[2].press_kill_switch(true);
  bench.tics[2].press_kill_switch(false);
  TicDrives drives(bench.settings);
  CHECK_FALSE(drives.status()[2].stopped_by_hand);
  drives.energize();
  CHECK(drives.status()[2].energized);
  CHECK(drives.status()[2].faults.empty());
}

TEST_CASE("Destruction halts what moves") {
  TicBench bench;
  {
    ReadyDrives ready(bench);
    ready.drives.set_targets({3900, 0, 0});
    CHECK(eventually([&] { return ready.drives.status()[0].position_pulses > 100; }));
  }
  const std::int32_t stopped_at = bench.tics[0].shaft_pulses();
  sleep_s(0.05);
  CHECK(bench.tics[0].shaft_pulses() == stopped_at);
}

TEST_CASE("The next program finds the drives where they were left, with no need to home") {
  TicBench bench(kShortTimeout_s);
  {
    ReadyDrives ready(bench);
    ready.drives.set_targets({300, -500, 900});
    CHECK(eventually([&] { return at_rest_at(ready.drives, {300, -500, 900}); }));
  }
  sleep_s(2 * kShortTimeout_s);
  TicDrives next(bench.settings);
  next.energize();
  const auto status = next.status();
  for (const DriveStatus& drive : status) {
    CHECK(drive.energized);
    CHECK(drive.position_certain);
  }
  CHECK(status[2].position_pulses == 900);
  CHECK(bench.tics[2].shaft_pulses() == 900);
}

}  // namespace planar
