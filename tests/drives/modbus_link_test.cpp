#include "planar_servo/hardware/links/modbus_link.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdio>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/hardware/links/command_link.h"
#include "planar_servo/hardware/links/linked_drives.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/link_bench.h"

namespace planar {
namespace {

using Catch::Contains;
using Catch::Matchers::Equals;
using test::all_rest;
using test::make_ready;
using test::positions;
using Targets = test::LinkTargets;

constexpr DriveLimits kRated{20000.0, 100000.0};

/// Emulated drivers on a line of their own, whose telegrams pymodbus frames and decodes.
struct Bus {
  explicit Bus(const std::vector<std::string>& options, const std::string& map = "leadshine-rs")
      : drivers(program(folder, options)) {
    REQUIRE(drivers.next_line(20.0) == "ready");
    line.port = (folder / "port").string();
    line.map = read_modbus_map(PLANAR_MODBUS_MAPS "/" + map + ".yaml");
  }
  static MotionProgram program(const test::TemporaryFolder& folder,
                               const std::vector<std::string>& options) {
    MotionProgram program{{"/usr/bin/python3", "-B", PLANAR_DRIVE_TESTS "/modbus_drivers.py",
                           PLANAR_EXAMPLES, (folder / "port").string()},
                          "/"};
    program.words.insert(program.words.end(), options.begin(), options.end());
    return program;
  }
  LinkedDrives drives() const {
    return {"the drivers", {kRated, kRated, kRated}, [this] {
              return std::make_unique<ModbusLink>(line);
            }};
  }

  test::TemporaryFolder folder;
  ChildProgram drivers;
  ModbusLine line;
};

bool has_pymodbus() {
  MotionProgram probe{{"/usr/bin/python3", "-c", "import pymodbus; print('yes')"}, "/"};
  try {
    return ChildProgram(probe).next_line(10.0) == "yes";
  } catch (const WorkError&) {
    return false;
  }
}

#define REQUIRE_PYMODBUS()                     \
  if (!has_pymodbus()) {                       \
    std::puts("skipped: no python3-pymodbus"); \
    return;                                    \
  }

TEST_CASE("Drivers of two makes go where they are sent, together, and brake when halted") {
  REQUIRE_PYMODBUS();
  const bool is_oriental = GENERATE(false, true);
  const Bus bus({"--make", is_oriental ? "oriental" : "leadshine"},
                is_oriental ? "oriental-az" : "leadshine-rs");
  LinkedDrives drives = bus.drives();
  CHECK_FALSE(drives.status()[0].position_certain);
  make_ready(drives);
  drives.set_targets({12000, -3000, 40});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{12000, -3000, 40});
  CHECK(drives.status()[2].faults.empty());
  drives.set_targets({0, 0, 0});
  const SteadyClock clock;
  const double until_s = clock.now_s() + 0.25;
  REQUIRE(test::eventually([&] { return clock.now_s() > until_s; }));
  drives.halt();
  const Targets rest = positions(drives);
  CHECK((rest[0] > 0 && rest[0] < 12000));
  CHECK(drives.status()[0].position_certain);
  drives.set_targets({0, 0, 0});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{0, 0, 0});
}

TEST_CASE("Telegrams that are lost, garbled, late or a stranger's are repeated, and counted") {
  REQUIRE_PYMODBUS();
  const std::string fault = GENERATE("--lose", "--garble", "--stranger");
  INFO(fault);
  const Bus bus({fault, "7"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({5000, 5000, -5000});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{5000, 5000, -5000});
  ModbusLink link(bus.line);
  for (int i = 0; i < 10; ++i) link.read();
  const LineErrors& errors = link.errors();
  CHECK(errors.telegrams > 60);
  CHECK((fault == "--lose" ? errors.unanswered : errors.garbled) >= errors.telegrams / 10);
}

TEST_CASE("A driver that says nothing is named with what to look at") {
  REQUIRE_PYMODBUS();
  SECTION("from the start") {
    const Bus bus({"--addresses", "1,2,4"});
    CHECK_THROWS_WITH(bus.drives(), Contains("drive 3 (address 3) does not tell its status") &&
                                        Contains("no answer within 100 ms, 3 times") &&
                                        Contains("look at address, baud, parity"));
  }
  SECTION("in mid-move") {
    const Bus bus({"--mute-moving", "2"});
    LinkedDrives drives = bus.drives();
    make_ready(drives);
    drives.set_targets({0, 20000, 0});
    REQUIRE(test::eventually([&] { return !drives.status()[0].answers; }));
    CHECK_THAT(drives.status()[0].faults.front(), Contains("drive 2 (address 2)"));
    CHECK_FALSE(drives.status()[1].position_certain);
  }
  SECTION("because there is no line") {
    ModbusLine line;
    line.port = "/absent/port";
    CHECK_THROWS_WITH(ModbusLink(line), Contains("/absent/port cannot be opened"));
  }
  SECTION("with registers of another make") {
    const Bus bus({}, "oriental-az");
    CHECK_THROWS_WITH(bus.drives(), Contains("the registers may be those of another driver"));
  }
}

TEST_CASE("An alarm in mid-move is named, and switching on again clears it") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--alarm-moving", "1"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({20000, 0, 0});
  REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
  CHECK_THAT(drives.status()[0].faults.front(), Equals("drive 1 (address 1) reports alarm 0xe0"));
  REQUIRE(all_rest(drives));
  CHECK_THROWS_WITH(drives.set_targets({0, 0, 0}), Contains("alarm 0xe0"));
  drives.energize();
  drives.set_targets({0, 0, 0});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{0, 0, 0});
}

TEST_CASE("Words in the other order are refused before a move of 65,536 counts") {
  REQUIRE_PYMODBUS();
  SECTION("by the positions that the drivers tell") {
    const Bus bus({"--low-first", "--at", "5,0,-300"});
    CHECK_THROWS_WITH(bus.drives(), Contains("327680, which is 5 with its two words exchanged") &&
                                        Contains("exchange word_order"));
  }
  SECTION("by the first count of drivers that stand at 0") {
    const Bus bus({"--low-first"});
    LinkedDrives drives = bus.drives();
    make_ready(drives);
    CHECK_THROWS_WITH(
        drives.set_targets({9000, -100, 0}),
        Contains("drive 1 (address 1) was sent from 0 to 1") && Contains("look at word_order"));
    ModbusLine other = bus.line;
    other.map.high_word_first = false;
    ModbusLink link(other);
    REQUIRE(test::eventually([&] { return !link.read().moving; }));
    CHECK(std::abs(link.read().counts[0]) < 100);
  }
  SECTION("and not where it is right") {
    const Bus bus({"--at", "70000,0,-1"});
    LinkedDrives drives = bus.drives();
    make_ready(drives);
    drives.set_targets({100, 100, 100});
    REQUIRE(all_rest(drives));
    CHECK(positions(drives) == Targets{100, 100, 100});
  }
}

TEST_CASE("Drivers that do not begin are seen to rest elsewhere") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--deaf-to-start", "--at", "3,3,3"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({100, 100, 100});
  REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
  CHECK_THAT(drives.status()[0].faults.front(),
             Contains("came to rest at 3, 3, 3 counts, where it was sent to 103, 103, 103"));
}

TEST_CASE("A home switch is searched by the driver, which counts from there") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--at", "900,0,0"});
  LinkedDrives drives = bus.drives();
  drives.energize();
  drives.start_homing(0, HomeDirection::kReverse);
  CHECK(drives.status()[0].homing);
  REQUIRE(test::eventually([&] { return !drives.status()[0].homing; }));
  CHECK(drives.status()[0].position_certain);
  CHECK(drives.status()[0].position_pulses == 0);
  CHECK_FALSE(drives.status()[1].position_certain);
}

TEST_CASE("A map of registers is read, and each fault of it named") {
  const test::TemporaryFolder folder;
  const std::string good = read_file(PLANAR_MODBUS_MAPS "/leadshine-rs.yaml");
  const auto refusal_of = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
    try {
      read_modbus_map(folder.write("map.yaml", text));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const ModbusMap map = read_modbus_map(PLANAR_MODBUS_MAPS "/leadshine-rs.yaml");
  CHECK(map.position.address == 0x1014);
  CHECK(map.position.words == 2);
  CHECK(map.move.front().values.size() == 6);
  CHECK(map.start->values.front().number == 0x10);
  CHECK_THAT(refusal_of("0x1014 2", "0x1014 3"), Contains("write REGISTER WORDS"));
  CHECK_THAT(refusal_of("moving: \"2\"", "moving: \"two\""), Contains("number of a bit"));
  CHECK_THAT(refusal_of("1 position speed", "1 place speed"), Contains("'0x6200: 1 place speed"));
  CHECK_THAT(refusal_of("1 position speed", "1 1 speed"), Contains("writes no position"));
  CHECK_THAT(refusal_of("0x6002: 0x10", "0x16002: 0x10"), Contains("not understood"));
  CHECK_THAT(refusal_of("speed: rpm", "speed: rps"), Contains("counts_per_s"));
  CHECK_THAT(refusal_of("stop:", "stopp:"), Contains("stop"));
}

TEST_CASE("Three joints of a cell are three drivers of one make on one line") {
  const test::TemporaryFolder folder;
  std::filesystem::copy_file(PLANAR_MODBUS_MAPS "/leadshine-rs.yaml", folder / "map.yaml");
  const auto driver = [](const std::string& address, const std::string& parity = "none") {
    return fmt::format(
        "kind: modbus, port: /dev/a, baud: 115200, registers: map.yaml, address: {}, "
        "parity: {}",
        address, parity);
  };
  const auto cell_with = [&](const std::array<std::string, 3>& drivers) {
    return test::cell_with_drives(folder, drivers);
  };
  CHECK_THROWS_WITH(read_cell(cell_with({driver("1"), driver("1"), driver("3")})),
                    Contains("drives[1] has address 1 as drives[0]"));
  CHECK_THROWS_WITH(read_cell(cell_with({driver("1"), driver("2"), driver("3", "even")})),
                    Contains("drives[2] has another line or map than drives[0]"));
  CHECK_THROWS_WITH(read_cell(cell_with({driver("1"), driver("2"), driver("300")})),
                    Contains("address"));
  CHECK(read_cell(cell_with({driver("1"), driver("2"), driver("3")})).drives[2].kind->name() ==
        "modbus");
}

}  // namespace
}  // namespace planar
