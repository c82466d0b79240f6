// Grbl 1.1h and grblHAL themselves, built for this machine from the archives beside the checkout.
#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <thread>

#include "planar_servo/hardware/drives/grbl_drives.h"
#include "support/counted_firmware.h"
#include "support/eventually.h"
#include "support/grbl_bench.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::eventually;
using test::Refused;
using Steps = std::array<int, 3>;

const EmulatedGrbl::Settings kStored{{1, 255},   {110, 960}, {111, 960}, {112, 960},
                                     {120, 160}, {121, 160}, {122, 160}};

/// Returns the simulator of this name. When it is absent, a skip is printed and nothing is
/// returned.
std::optional<std::filesystem::path> simulator(const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(PLANAR_FIRMWARE) / name;
  if (std::filesystem::exists(path)) return path;
  std::puts("skipped: no firmware of Grbl");
  return std::nullopt;
}

/// Real firmware behind drives that are switched on and stand at 0.
struct FirmwareBench {
  explicit FirmwareBench(const std::filesystem::path& its_simulator)
      : firmware(its_simulator, kStored),
        drives(std::make_unique<GrblDrives>(test::grbl_settings_of(firmware.port()))) {
    drives->energize();
    for (int i = 0; i < 3; ++i) drives->set_position(i, 0);
  }

  void go(const std::array<std::int32_t, 3>& targets) {
    drives->set_targets(targets);
    REQUIRE(eventually([&] { return !drives->status()[0].moving; }));
    for (std::size_t i = 0; i < 3; ++i) {
      REQUIRE(drives->status()[i].faults == std::vector<std::string>{});
      REQUIRE(drives->status()[i].position_pulses == targets[i]);
    }
  }

  void begin_long_move() {
    drives->set_targets({40000, 100, 20000});
    REQUIRE(eventually([&] { return drives->status()[0].position_pulses > 1000; }));
  }

  /// Says something to the firmware behind the drives' back.
  void say(const char* byte) const {
    const int port = open(firmware.port().c_str(), O_WRONLY | O_NOCTTY);
    REQUIRE(write(port, byte, 1) == 1);
    close(port);
  }

  /// Ends both and holds the steps made by joints 1 to 3 against what they should be.
  void check_steps(const Steps& expected) {
    drives.reset();
    const Steps steps = firmware.end();
    CHECK(Steps{steps[0], steps[2], steps[1]} == expected);
  }

  test::CountedFirmware firmware;
  std::unique_ptr<GrblDrives> drives;
};

TEST_CASE("Real firmware is refused with its factory's settings, and taken with the cell's") {
  const auto path = simulator(GENERATE("grbl_sim", "grblHAL_sim"));
  if (!path) return;
  const test::CountedFirmware factory(*path, {});
  CHECK_THROWS_MATCHES(GrblDrives(test::grbl_settings_of(factory.port())), DriveError,
                       Refused(Cause::kContradiction, "$1=255 and $110=960 and $120=160"));
  FirmwareBench bench(*path);
  CHECK(bench.drives->status()[0].energized);
  bench.check_steps(Steps{0, 0, 0});
}

TEST_CASE("Real firmware makes the steps that were commanded") {
  const auto path = simulator(GENERATE("grbl_sim", "grblHAL_sim"));
  if (!path) return;
  FirmwareBench bench(*path);
  std::mt19937 random(3);
  std::uniform_int_distribution<int> pulses(-200, 200);
  Steps last{};
  for (int i = 0; i < 25; ++i) {
    last = {pulses(random), pulses(random), pulses(random)};
    bench.go(last);
  }
  last = {3001, -1999, 7};
  bench.go(last);
  bench.check_steps(last);
}

TEST_CASE("Real firmware rests at once when halted, knows where, and can move on") {
  const auto path = simulator(GENERATE("grbl_sim", "grblHAL_sim"));
  if (!path) return;
  FirmwareBench bench(*path);
  bench.begin_long_move();
  bench.drives->halt();
  const auto status = bench.drives->status();
  CHECK_FALSE(status[0].moving);
  CHECK(status[0].position_certain);
  CHECK(status[0].position_pulses < 20000);
  bench.go({status[0].position_pulses + 100, 5, 5});
  bench.check_steps(Steps{status[0].position_pulses + 100, 5, 5});
}

TEST_CASE("Real firmware rests soon when its caller goes silent, on its way") {
  const auto path = simulator(GENERATE("grbl_sim", "grblHAL_sim"));
  if (!path) return;
  FirmwareBench bench(*path);
  bench.begin_long_move();
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const DriveStatus here = bench.drives->status()[0];
  CHECK(here.position_pulses < 20000);
  CHECK(here.position_certain);
  CHECK(here.faults.empty());
  bench.drives->halt();
}

TEST_CASE("Real firmware that is told to hold by hand rests, and its driver says so") {
  const auto path = simulator("grbl_sim");
  if (!path) return;
  FirmwareBench bench(*path);
  bench.begin_long_move();
  bench.say("!");
  REQUIRE(eventually([&] { return !bench.drives->status()[0].faults.empty(); }));
  CHECK(bench.drives->status()[0].faults.front() ==
        "it has stopped on its way (was it told to hold?)");
  CHECK(eventually([&] { return !bench.drives->status()[0].moving; }));
  CHECK(bench.drives->status()[0].position_pulses < 20000);
  CHECK(bench.drives->status()[0].position_certain);
  bench.drives->energize();
  bench.go({bench.drives->status()[0].position_pulses + 100, 5, 5});
}

TEST_CASE("Real firmware that was reset on its way asks for homing") {
  const auto path = simulator(GENERATE("grbl_sim", "grblHAL_sim"));
  if (!path) return;
  FirmwareBench bench(*path);
  bench.begin_long_move();
  bench.say("\x18");
  CHECK(eventually([&] { return !bench.drives->status()[0].faults.empty(); }));
  CHECK_FALSE(bench.drives->status()[0].position_certain);
  CHECK_THROWS_AS(bench.drives->set_targets({0, 0, 0}), DriveError);
  bench.drives->energize();
  CHECK(bench.drives->status()[0].energized);
  CHECK_FALSE(bench.drives->status()[0].position_certain);
}

TEST_CASE("Real firmware keeps whole pulses far from its origin") {
  const auto path = simulator(GENERATE("grbl_sim", "grblHAL_sim"));
  if (!path) return;
  const test::CountedFirmware firmware(
      *path,
      {{1, 255}, {110, 48000}, {111, 48000}, {112, 48000}, {120, 8000}, {121, 8000}, {122, 8000}});
  GrblSettings settings = test::grbl_settings_of(firmware.port());
  for (GrblAxis& axis : settings.axes) {
    axis.speed_pulses_s = 200000.0;
    axis.acceleration_pulses_s2 = 2000000.0;
  }
  GrblDrives drives(settings);
  drives.energize();
  for (const int target : {100001, 100002, 99999}) {
    drives.set_targets({target, 0, -target});
    REQUIRE(eventually([&] { return !drives.status()[0].moving; }));
    CHECK(drives.status()[0].position_pulses == target);
    CHECK(drives.status()[2].position_pulses == -target);
  }
}

}  // namespace
}  // namespace planar
