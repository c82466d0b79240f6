#include "planar_servo/hardware/links/modbus_link.h"

#include <fmt/format.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <random>
#include <sstream>
#include <utility>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/hardware/links/command_link.h"
#include "planar_servo/hardware/links/linked_drives.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/grbl_bench.h"
#include "support/link_bench.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using Catch::Matchers::Equals;
using test::all_rest;
using test::make_ready;
using test::positions;
using test::Refused;
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
    MotionProgram program{
        {"/usr/bin/python3", "-B", std::string(PLANAR_DRIVE_TESTS) + "/modbus_drivers.py",
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

  /// Returns a cell with these drivers, whose file and map it writes.
  CellSettings cell(const std::string& map = read_file(PLANAR_MODBUS_MAPS
                                                       "/leadshine-rs.yaml")) const {
    folder.write("map.yaml", map);
    const auto driver = [&](int address) {
      return fmt::format(
          "kind: modbus, port: {}, baud: 115200, parity: none, registers: map.yaml, address: {}",
          line.port, address);
    };
    return read_cell(test::cell_with_drives(folder, {driver(1), driver(2), driver(3)}));
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
  const std::string fault = GENERATE("--lose", "--garble", "--stranger", "--late");
  INFO(fault);
  // Of this make status and position are alike, so that one could be taken for the other.
  const Bus bus({fault, "7", "--make", "oriental", "--at", "70000,0,0"}, "oriental-az");
  {
    LinkedDrives drives = bus.drives();
    make_ready(drives);
    drives.set_targets({5000, 5000, -5000});
    REQUIRE(test::eventually([&] {
      const DriveStatus status = drives.status()[0];
      CHECK(status.faults.empty());  // as that one rests on its way, for another answers late
      return !status.moving;
    }));
    CHECK(positions(drives) == Targets{5000, 5000, -5000});
  }
  ModbusLink link(bus.line);
  for (int i = 0; i < 10; ++i) link.read();
  const LineErrors& errors = link.errors();
  CHECK(errors.telegrams > 60);
  const int counted = fault == "--garble"     ? errors.garbled
                      : fault == "--stranger" ? errors.foreign
                                              : errors.unanswered;
  CHECK(counted >= errors.telegrams / 10);
  CHECK(counted == errors.all());
}

TEST_CASE("A stranger on the line is told by the tenth error, once, apart from what is garbled") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--stranger", "3", "--garble", "4"});
  std::ostringstream said;
  const auto usual = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  {
    ModbusLink link(bus.line);
    while (link.errors().all() < 10) link.read();
    CHECK_THAT(said.str(), Contains("answered from another address"));
    link.read();
  }
  spdlog::set_default_logger(usual);
  const std::string warning = said.str();
  CHECK_THAT(warning, Contains(bus.line.port + ": of ") && Contains("another master may be") &&
                          Contains("two drivers may have one address"));
  CHECK(warning.find("another master") == warning.rfind("another master"));
}

TEST_CASE("An answer may take longer than a second where the cell says so") {
  REQUIRE_PYMODBUS();
  Bus bus({"--hang-moving", "--at", "70000,0,0"});
  bus.line.answer_s = 3.0;
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({5000, 0, 0});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{5000, 0, 0});
  CHECK(drives.status()[0].position_certain);
}

TEST_CASE("A driver that says nothing is named with what to look at") {
  REQUIRE_PYMODBUS();
  SECTION("from the start") {
    const Bus bus({"--addresses", "1,2,4"});
    CHECK_THROWS_MATCHES(bus.drives(), DriveError, Refused(Cause::kDevice, "drive 3 (address 3)"));
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
    CHECK_THROWS_MATCHES(ModbusLink(line), WorkError, Refused(Cause::kMissing, "/absent/port"));
  }
  SECTION("because another program has the line") {
    const Bus bus({});
    const test::PortReader cat(bus.line.port);
    CHECK_THROWS_MATCHES(ModbusLink(bus.line), WorkError, Refused(Cause::kBusy, cat.name()));
  }
  SECTION("with registers of another make") {
    const Bus bus({}, "oriental-az");
    CHECK_THROWS_MATCHES(bus.drives(), DriveError, Refused(Cause::kDevice, "registers"));
  }
}

TEST_CASE("An alarm in mid-move is named, and switching on again clears it") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--alarm-moving", "1", "--at", "70000,0,0"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({20000, 0, 0});
  REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
  CHECK_THAT(drives.status()[0].faults.front(),
             Equals("drive 1 (address 1) reports alarm 0xe0 in register 0x2203"));
  REQUIRE(all_rest(drives));
  CHECK_THROWS_MATCHES(drives.set_targets({0, 0, 0}), DriveError,
                       Refused(Cause::kDevice, "alarm 0xe0"));
  drives.energize();
  drives.set_targets({0, 0, 0});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{0, 0, 0});
}

TEST_CASE("A driver that starts anew in a move has lost its position, also once it is on again") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--restart-moving", "1", "--at", "70000,0,0"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({20000, 20000, 0});
  REQUIRE(test::eventually([&] { return !drives.status()[0].position_certain; }));
  CHECK(drives.status()[0].stopped_by_hand);
  REQUIRE(all_rest(drives));
  drives.energize();
  CHECK_FALSE(drives.status()[0].position_certain);
  CHECK_THROWS_MATCHES(drives.set_targets({0, 0, 0}), DriveError,
                       Refused(Cause::kDevice, "drive 1"));
}

/// Returns the motors' counts as the emulated drivers wrote them last.
Targets last_counts(const std::filesystem::path& shafts) {
  std::istringstream text(read_file(shafts));
  Targets counts{};
  for (std::string line; std::getline(text, line);) {
    std::istringstream numbers(line.rfind("at ", 0) == 0 ? line.substr(3) : line);
    for (std::int32_t& count : counts) numbers >> count;
  }
  return counts;
}

TEST_CASE("Whatever strikes drivers on Modbus in a move is named, and the arm rests") {
  REQUIRE_PYMODBUS();
  struct Fault {
    std::vector<std::string> options;
    const char* said;
    bool answers;
    bool broadcasts{true};
  };
  const std::vector<Fault> faults{
      {{"--mute-moving", "2"}, "drive 2 (address 2) does not tell its", false},
      {{"--mute-moving", "2", "--single"}, "drive 2 (address 2) does not tell its", false, false},
      {{"--alarm-moving", "3"}, "drive 3 (address 3) reports alarm 0xe0", true},
      {{"--stall-moving", "1"}, "drive 1 (address 1) rests at", true},
      {{"--end-moving"}, "drive ", false},
      {{"--hang-moving"}, "no answer within 100 ms, 3 times", false}};
  std::mt19937 random(40);
  std::uniform_real_distribution<double> when_s(0.02, 1.3);  // the move takes 1.7 s
  constexpr double kEarly_s = 1.0;  // enough before the end for three telegrams to stay unanswered
  for (int i = 0; i < test::faults_to_inject(static_cast<int>(faults.size())); ++i) {
    const Fault& fault = faults[static_cast<std::size_t>(i) % faults.size()];
    std::vector<std::string> options = fault.options;
    const test::TemporaryFolder folder;
    const auto shafts = folder / "shafts";
    const double after_s = when_s(random);
    for (const std::string& word :
         {std::string("--after"), std::to_string(after_s), std::string("--shafts"), shafts.string(),
          std::string("--at"), std::string("70000,0,0")})  // which shows the order of words
      options.push_back(word);
    INFO(fmt::format("{}", fmt::join(options, " ")));
    Bus bus(options);
    if (!fault.broadcasts) {
      bus.line.map.move.push_back(*bus.line.map.start);
      bus.line.map.start.reset();
    }
    LinkedDrives drives = bus.drives();
    make_ready(drives);
    drives.set_targets({30000, 30000, -30000});
    const test::Struck struck = test::wait_for_fault(drives);
    CHECK(struck.rests);
    CHECK_THAT(struck.said, Contains(fault.said));
    CHECK(drives.status()[0].answers == fault.answers);
    CHECK(struck.certain == fault.answers);
    // A driver that failed tells the others nothing: the program stops them.
    if (!fault.answers && fault.options[0] != "--end-moving" && after_s < kEarly_s) {
      Targets before{};
      SteadyClock clock;
      REQUIRE(test::eventually([&] {
        const Targets seen = last_counts(shafts);
        clock.sleep_for_s(0.1);
        return std::exchange(before, seen) == seen && seen == last_counts(shafts);
      }));
      CHECK(std::abs(before[0]) < 30000);
      CHECK(std::abs(before[2]) < 30000);
    }
    if (fault.answers) {
      CHECK(positions(drives) == last_counts(shafts));
      CHECK_THROWS_AS(drives.set_targets({0, 0, 0}), DriveError);
    }
  }
}

TEST_CASE("A stop reaches the other drivers where one does not answer it") {
  REQUIRE_PYMODBUS();
  const test::TemporaryFolder folder;
  const auto shafts = folder / "shafts";
  Bus bus(
      {"--mute-moving", "1", "--after", "0.2", "--shafts", shafts.string(), "--at", "70000,0,0"});
  bus.line.answer_s = 0.3;
  const bool broadcasts = GENERATE(true, false);
  if (!broadcasts) {
    bus.line.map.move.push_back(*bus.line.map.start);
    bus.line.map.start.reset();
  }
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({50000, 50000, -50000});
  SteadyClock clock;
  clock.sleep_for_s(0.3);
  CHECK_THROWS_MATCHES(drives.halt(), DriveError, Refused(Cause::kDevice, "drive 1 (address 1)"));
  Targets before{};
  REQUIRE(test::eventually([&] {
    const Targets seen = last_counts(shafts);
    clock.sleep_for_s(0.1);
    return std::exchange(before, seen) == seen && seen == last_counts(shafts);
  }));
  constexpr int kOneAnswer = 18000;  // 0.3 s until the halt, 0.3 s for an answer, and braking
  CHECK((before[1] > 0 && before[1] < kOneAnswer));
  CHECK((before[2] < 0 && before[2] > -kOneAnswer));
}

TEST_CASE("Words in the other order are refused before a move of 65,536 counts") {
  REQUIRE_PYMODBUS();
  SECTION("by the positions that the drivers tell") {
    const Bus bus({"--low-first", "--at", "5,0,-300"});
    CHECK_THROWS_MATCHES(bus.drives(), DriveError, Refused(Cause::kContradiction, "327680"));
  }
  SECTION("by the first count of drivers that stand at 0") {
    const int way = GENERATE(9000, -9000);  // -1 is the same in both orders
    const Bus bus({"--low-first"});
    LinkedDrives drives = bus.drives();
    make_ready(drives);
    drives.set_targets({way, -100, 0});
    REQUIRE(test::eventually([&] { return !drives.status()[0].answers; }));
    CHECK_FALSE(drives.status()[0].position_certain);
    CHECK_NOTHROW(drives.halt());
    CHECK_THROWS_MATCHES(drives.set_targets({way, -100, 0}), DriveError,
                         Refused(Cause::kContradiction, "drive 1 (address 1)"));
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

TEST_CASE("Drivers whose ramps have a range are sent no other, at first and where they rest, too") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--ramps", "10,32767"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  // Beside a long way a short one would have a ramp of minutes.
  for (const Targets& targets : {Targets{0, 9000, 0}, Targets{9000, 9002, 0}}) {
    drives.set_targets(targets);
    REQUIRE(all_rest(drives));
    CHECK(positions(drives) == targets);
    CHECK(drives.status()[1].faults.empty());
  }
}

TEST_CASE("What a driver refuses is named and not repeated, all are stopped, and none is lost") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--ramps", "10,1000", "--at", "70000,0,0"});
  {
    LinkedDrives drives = bus.drives();
    make_ready(drives);
    CHECK_THROWS_MATCHES(
        drives.set_targets({9000, 0, 0}), DriveError,
        Refused(Cause::kDevice, "1667 1667 0 in register 0x6200): Illegal data value"));
    CHECK_NOTHROW(drives.halt());
    CHECK(drives.status()[0].answers);
    CHECK(drives.status()[0].position_certain);
    CHECK_FALSE(drives.status()[0].moving);
  }
  ModbusLink link(bus.line);
  const int before = link.errors().telegrams;
  CHECK_THROWS_AS(link.go_to(Pulses(79000, 0, 0), {kRated, kRated, kRated}), MachineRefusal);
  constexpr int kStops = 1 + 3;  // for all at once, and for each
  CHECK(link.errors().telegrams - before == 1 + kStops);
}

TEST_CASE("A move that is refused once the order of words is shown loses no position") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--ramps", "10,2000"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({9000, 3, 0});  // for 3 counts beside 9000 the ramp would be the longest
  REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
  CHECK(drives.status()[0].answers);
  CHECK_THAT(drives.status()[0].faults.front(), Contains("drive 2") && Contains("Illegal data"));
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{10, 0, 0});
  CHECK(drives.status()[0].position_certain);
  CHECK_THROWS_MATCHES(drives.set_targets({9000, 9000, 0}), DriveError,
                       Refused(Cause::kDevice, "`enable` clears this"));
  drives.energize();
  drives.set_targets({9000, 9000, 0});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{9000, 9000, 0});
}

TEST_CASE("A closed loop that takes three counts for no way shows the order of its words, too") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--window", "3"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  const int way = GENERATE(9000, -9000);
  drives.set_targets({way, 0, 0});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{way, 0, 0});
  CHECK(drives.status()[0].faults.empty());
}

TEST_CASE("A driver that moves whatever it is told is named with the bit that says so") {
  REQUIRE_PYMODBUS();
  Bus bus({});
  bus.line.map.moving.bit = 1;  // which tells that it is on
  LinkedDrives drives = bus.drives();
  drives.energize();
  CHECK_THROWS_MATCHES(
      drives.halt(), DriveError,
      Refused(Cause::kDevice, "drive 3 (address 3) says so by bit 1 of its status, 0x0002"));
}

TEST_CASE("A driver that fails as one shows the order of its words keeps all from their way") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--alarm-moving", "1", "--after", "0.03"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({9000, 8000, 0});
  const SteadyClock clock;
  const double until_s = clock.now_s() + 0.5;  // it would go on after 0.1 s
  REQUIRE(test::eventually([&] {
    const auto status = drives.status();
    CHECK(status[1].position_pulses == 0);
    return clock.now_s() > until_s;
  }));
  CHECK_THAT(drives.status()[0].faults.front(), Contains("alarm 0xe0"));
}

TEST_CASE("A stop is obeyed while a driver still shows the order of its words") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--deaf-to-start"});  // which is waited for, for a second
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  const SteadyClock clock;
  const double begun_s = clock.now_s();
  drives.set_targets({9000, 0, 0});
  CHECK(drives.status()[0].moving);
  drives.halt();
  CHECK(clock.now_s() - begun_s < 0.5);
  CHECK_FALSE(drives.status()[0].moving);
  CHECK(drives.status()[0].position_certain);
  CHECK(positions(drives) == Targets{0, 0, 0});
}

TEST_CASE("Drivers that do not begin are seen to rest elsewhere") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--deaf-to-start", "--at", "3,3,3"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({100, 100, 100});
  REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
  CHECK_THAT(drives.status()[0].faults.front(),
             Contains("came to rest at 3, 3, 3 counts, where it was sent to 103, 103, 103") &&
                 Contains("it did not begin: look at `move` and `start` of its map; it came"));
}

TEST_CASE("Drivers at 0 that do not begin are not taken for some whose words are exchanged") {
  REQUIRE_PYMODBUS();
  const Bus bus({"--deaf-to-start"});
  LinkedDrives drives = bus.drives();
  make_ready(drives);
  drives.set_targets({9000, 0, 0});
  REQUIRE(test::eventually([&] { return !drives.status()[0].answers; }));
  CHECK_THAT(drives.status()[0].faults.front(),
             Contains("sent from 0 to 10 and stays at 0") && Contains("`move` or `start`"));
  CHECK_THROWS_MATCHES(drives.set_targets({9000, 0, 0}), DriveError,
                       Refused(Cause::kDevice, "drive 1 (address 1)"));
  CHECK_NOTHROW(drives.halt());
}

TEST_CASE("A home switch is searched by the driver, which counts from there") {
  REQUIRE_PYMODBUS();
  const bool is_oriental = GENERATE(false, true);
  const Bus bus({"--at", "900,0,0", "--make", is_oriental ? "oriental" : "leadshine"},
                is_oriental ? "oriental-az" : "leadshine-rs");
  LinkedDrives drives = bus.drives();
  drives.energize();
  drives.start_homing(0, HomeDirection::kReverse);
  CHECK(drives.status()[0].homing);
  REQUIRE(test::eventually([&] { return !drives.status()[0].homing; }));
  CHECK(drives.status()[0].position_certain);
  CHECK(drives.status()[0].position_pulses == 0);
  CHECK_FALSE(drives.status()[1].position_certain);
}

TEST_CASE(
    "A search that does not find its home switch is a fault, and leaves the joint uncertain") {
  REQUIRE_PYMODBUS();
  struct Failure {
    std::vector<std::string> options;
    std::string map, said;
  };
  const auto [options, map, said] = GENERATE(
      values<Failure>({{{"--deaf-to-home"}, "leadshine-rs", "did not begin to move"},
                       {{"--stall-moving", "1"}, "leadshine-rs", "gave up"},
                       {{"--make", "oriental", "--stall-moving", "1"}, "oriental-az", "gave up"}}));
  INFO(said);
  std::vector<std::string> all = options;
  for (const char* word : {"--at", "9000,0,0"}) all.emplace_back(word);
  const Bus bus(all, map);
  LinkedDrives drives = bus.drives();
  drives.energize();
  drives.start_homing(0, HomeDirection::kReverse);
  REQUIRE(test::eventually([&] { return !drives.status()[0].homing; }));
  const DriveStatus status = drives.status()[0];
  CHECK_FALSE(status.position_certain);
  REQUIRE(status.faults.size() == 1);
  CHECK_THAT(status.faults[0],
             Contains("drive 1 (address 1) has not found its home switch: it " + said));
  drives.energize();
  CHECK(drives.status()[0].faults.empty());
}

TEST_CASE("A map of registers is read, and each fault of it named") {
  const test::TemporaryFolder folder;
  const std::string good = read_file(PLANAR_MODBUS_MAPS "/leadshine-rs.yaml");
  const auto check_refused = [&](const std::string& from, const std::string& to,
                                 const std::string& name, Cause cause = Cause::kInvalid) {
    std::string text = good;
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
    INFO(to);
    CHECK_THROWS_MATCHES(read_modbus_map(folder.write("map.yaml", text)), InputError,
                         Refused(cause, name));
  };
  const ModbusMap map = read_modbus_map(PLANAR_MODBUS_MAPS "/leadshine-rs.yaml");
  CHECK(map.position.address == 0x1014);
  CHECK(map.position.words == 2);
  CHECK(map.move.front().values.size() == 6);
  CHECK(map.start->values.front().number == 0x10);
  check_refused("0x1014 2", "0x1014 3", "'0x1014 3'");
  check_refused("moving: \"2\"", "moving: \"two\"", "'two'");
  check_refused("1 position speed", "1 place speed", "'0x6200: 1 place speed");
  check_refused("moving: \"2\"", "moving: \"0x0004\"", "'0x0004'");
  check_refused("moving: \"2\"", "moving: \"not 0x2\"", "'not 0x2'");
  check_refused("1 position speed", "1 1 speed", "move writes no position", Cause::kMissing);
  check_refused("position speed", "position 1", "move writes no speed", Cause::kMissing);
  check_refused("0x1014 2", "0x1014 1", "map.yaml:9:");
  check_refused("0x1014 2", "0x1014 1", "position is one register");
  check_refused("moving: \"2\"", "moving: \"16\"", "moving is bit 16");
  check_refused("homed: \"6\"", "homed: \"16\"", "homed is bit 16");
  CHECK(map.homed->bit == 6);
  CHECK(read_modbus_map(PLANAR_MODBUS_MAPS "/oriental-az.yaml").homed->bit == 4);
  check_refused("0x6002: 0x10", "0x16002: 0x10", "'0x16002: 0x10'");
  check_refused("acceleration: ms_per_1000_rpm", "acceleration: rpm_per_s", "longest_ramp",
                Cause::kContradiction);
  check_refused("speed: rpm", "speed: rps", "'rps'");
  check_refused("speed: rpm", "speed: 0 rpm", "'0 rpm'");
  check_refused("stop:", "stopp:", "'stop'", Cause::kMissing);
  check_refused("0x1014 2", "40021 2", "40021");
  check_refused("0x6002: 0x40", "40021: 0x40", "40021");
  // 0x6203 has the speed, and 0x6206 the last 0.
  for (const char* start : {"0x6200: 1", "0x6203: 7", "0x6206: 0", "0x6205: 0/2"})
    check_refused("0x6002: 0x10", start, "start is written by move", Cause::kContradiction);
  check_refused("start: \"0x6002: 0x10", "start: \"0x6002: position", "start writes position");
  check_refused("0x6002: 0x40", "0x6002: acceleration", "stop writes acceleration");
}

TEST_CASE("A bit of one control word may start what a move has written with the bit off") {
  const test::TemporaryFolder folder;
  std::string text = read_file(PLANAR_MODBUS_MAPS "/leadshine-rs.yaml");
  const std::string moves = "0x6200: 1 position speed acceleration acceleration 0";
  REQUIRE(text.find(moves) != std::string::npos);
  text.replace(text.find(moves), moves.size(),
               "0x6201: position speed acceleration\", \"0x6002: 1");
  const ModbusMap map = read_modbus_map(folder.write("map.yaml", text));
  CHECK(map.move.back().address == map.start->address);
}

TEST_CASE("The doctor counts answers from another address apart, and names another master") {
  REQUIRE_PYMODBUS();
  const bool is_garbled = GENERATE(false, true);
  const Bus bus(is_garbled ? std::vector<std::string>{"--stranger", "3", "--garble", "4"}
                           : std::vector<std::string>{"--stranger", "3"});
  const CellSettings cell = bus.cell();
  const std::vector<Finding> findings = cell.drives[0].kind->examine(cell);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].verdict == Finding::Verdict::kDoubtful);
  CHECK((findings[0].fault.find(" 0 were garbled, ") == std::string::npos) == is_garbled);
  CHECK(findings[0].fault.find(" 0 answered from another address") == std::string::npos);
  CHECK_THAT(findings[0].remedy, Contains("another master may be on the line"));
  CHECK((findings[0].remedy.find("one address") == std::string::npos) == !is_garbled);
}

TEST_CASE("The doctor doubts a map by which every driver has a ramp of its own") {
  REQUIRE_PYMODBUS();
  const Bus bus({});
  std::string text = read_file(PLANAR_MODBUS_MAPS "/leadshine-rs.yaml");
  const bool has_ramp = GENERATE(true, false);
  const std::string ramps = "acceleration acceleration";
  if (!has_ramp) text.replace(text.find(ramps), ramps.size(), "100 100");
  const CellSettings cell = bus.cell(text);
  const std::vector<Finding> findings = cell.drives[0].kind->examine(cell);
  REQUIRE(findings.size() == 1);
  CHECK_THAT(findings[0].fault, Contains("all three answer") && Contains("0, 0, 0 counts, off"));
  CHECK(findings[0].verdict == (has_ramp ? Finding::Verdict::kWell : Finding::Verdict::kDoubtful));
  CHECK((findings[0].remedy.find("acceleration") == std::string::npos) == has_ramp);
}

TEST_CASE("Speeds and ramps are written in the driver's unit, which must fit its registers") {
  ModbusMap map;
  map.move = {{0x10, {{RegisterValue::What::kSpeed}, {RegisterValue::What::kAcceleration}}}};
  CHECK(map.speed_number(1234.7, 10000.0) == 1234);
  map.speed = {ModbusSpeed::kRpm, 1.0};
  CHECK(map.speed_number(10000.0, 10000.0) == 60);
  CHECK(map.speed_number(10.0, 10000.0) == 1);  // nothing slower
  map.speed.size = 0.01;
  CHECK(map.speed_number(12350.0, 10000.0) == 7410);
  CHECK(map.acceleration_number(2500.9, 10000.0) == 2500);
  map.acceleration = {ModbusAcceleration::kRpmPerS, 10.0};
  CHECK(map.acceleration_number(100000.0, 10000.0) == 60);
  map.acceleration = {ModbusAcceleration::kMsPer1000Rpm, 1.0};
  CHECK(map.acceleration_number(100000.0, 10000.0) == 1667);  // 600 rpm/s
  CHECK_FALSE(map.misfit({10000.0, 1e5}, 10000.0));
  const auto fast = map.misfit({2e5, 1e5}, 10000.0);  // 1200 rpm in hundredths
  REQUIRE(fast);
  CHECK_THAT(fast->text(), Contains("120000") && Contains("speed/2"));
  map.longest_ramp = 1600;
  CHECK(map.acceleration_number(100000.0, 10000.0) == 1600);
  CHECK_THAT(map.misfit({10000.0, 1e5}, 10000.0).value().text(), Contains("ramp of 1600"));
  map.acceleration = {ModbusAcceleration::kCounts, 1.0};
  CHECK_THAT(map.misfit({10000.0, 1e5}, 10000.0).value().text(), Contains("acceleration/2"));
  map.move[0].values[1].words = 2;
  CHECK_FALSE(map.misfit({10000.0, 1e5}, 10000.0));
  map.speed.size = 1000.0;
  CHECK_THAT(map.misfit({10000.0, 1e5}, 10000.0).value().text(),
             Contains("0.06 times 1000 rpm") && Contains("less than one unit"));
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
  CHECK_THROWS_MATCHES(read_cell(cell_with({driver("1"), driver("1"), driver("3")})), InputError,
                       Refused(Cause::kExists, "drives[1] has address 1"));
  CHECK_THROWS_MATCHES(read_cell(cell_with({driver("1"), driver("2"), driver("3", "even")})),
                       InputError, Refused(Cause::kContradiction, "parity"));
  CHECK_THROWS_MATCHES(read_cell(cell_with({driver("1"), driver("2"), driver("300")})), InputError,
                       Refused(Cause::kInvalid, "address"));
  CHECK(read_cell(cell_with({driver("1"), driver("2"), driver("3")})).drives[2].kind->name() ==
        "modbus");
  std::filesystem::remove(folder / "map.yaml");
  CHECK_THROWS_MATCHES(
      read_cell(cell_with({driver("1"), driver("2"), driver("3")})), InputError,
      Refused(Cause::kMissing, ": there is no map of registers " + (folder / "map.yaml").string()));
}

}  // namespace
}  // namespace planar
