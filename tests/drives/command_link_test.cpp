#include "planar_servo/hardware/links/command_link.h"

#include <sys/time.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <iterator>
#include <random>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/hardware/links/linked_drives.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/link_bench.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Contains;
using test::all_rest;
using test::make_ready;
using test::positions;
using test::Refused;
using Targets = test::LinkTargets;

constexpr DriveLimits kLimits{2000.0, 10000.0};
constexpr double kAnswer_s = 0.3;

MotionProgram example() {
  return {{"python3", "-B", PLANAR_EXAMPLES "/motion_program.py"}, "/", kAnswer_s};
}

MotionProgram faulty(const std::vector<std::string>& words) {
  MotionProgram program{
      {"python3", "-B", PLANAR_DRIVE_TESTS "/faulty_motion.py", PLANAR_EXAMPLES}, "/", kAnswer_s};
  program.words.insert(program.words.end(), words.begin(), words.end());
  return program;
}

LinkedDrives drives_of(const MotionProgram& program) {
  return {"the program", {kLimits, kLimits, kLimits}, [program] {
            return std::make_unique<CommandLink>(program);
          }};
}

TEST_CASE("A motion program moves the motors in the time that the slowest needs") {
  LinkedDrives drives = drives_of(example());
  CHECK_THROWS_MATCHES(drives.set_targets({1, 1, 1}), DriveError,
                       Refused(Cause::kDevice, "switched"));
  CHECK_FALSE(drives.status()[1].position_certain);
  drives.energize();
  drives.set_position(1, 500);
  CHECK(drives.status()[1].position_certain);
  CHECK_FALSE(drives.status()[0].position_certain);
  make_ready(drives);
  const SteadyClock clock;
  const double begun_s = clock.now_s();
  drives.set_targets({1000, -600, 0});
  CHECK(drives.status()[0].moving);
  CHECK(drives.status()[0].target_pulses == 1000);
  REQUIRE(all_rest(drives));
  // 1000 counts at 2000 a second, and 0.2 s to speed up or slow down.
  CHECK(clock.now_s() - begun_s == Approx(0.5 + 0.2).margin(0.1));
  CHECK(positions(drives) == Targets{1000, -600, 0});
  for (const DriveStatus& status : drives.status())
    CHECK((status.position_certain && status.faults.empty()));
  drives.set_limits({DriveLimits{200.0, 10000.0}, kLimits, kLimits});
  const double slow_s = clock.now_s();
  drives.set_targets({1100, -600, 0});
  REQUIRE(all_rest(drives));
  CHECK(clock.now_s() - slow_s == Approx(0.5).margin(0.1));
  CHECK_THROWS_MATCHES(drives.set_limits({DriveLimits{9e9, 1.0}, kLimits, kLimits}), InputError,
                       Refused(Cause::kInvalid, "9e+09 pulses/s"));
}

TEST_CASE("A motion program that is halted brakes, and the position stays certain") {
  for (const double after_s : {0.05, 0.3, 0.9}) {
    LinkedDrives drives = drives_of(example());
    make_ready(drives);
    drives.set_targets({1500, 300, -1500});
    const SteadyClock clock;
    const double until_s = clock.now_s() + after_s;
    REQUIRE(
        test::eventually([&] { return drives.status()[0].answers && clock.now_s() > until_s; }));
    const Targets before = positions(drives);
    drives.halt();
    const Targets rest = positions(drives);
    const double speed = std::min(2000.0, 10000.0 * after_s);
    CHECK(rest[0] - before[0] >= 0);
    CHECK(rest[0] - before[0] <= speed * speed / (2.0 * 10000.0) + 0.02 * speed);  // and its answer
    CHECK(rest[2] == -rest[0]);
    CHECK(drives.status()[0].position_certain);
    CHECK(drives.status()[0].faults.empty());
    // From there it goes on, also where it is told to while it moves.
    drives.set_targets({1500, 300, -1500});
    drives.set_targets({0, 0, 0});
    REQUIRE(all_rest(drives));
    CHECK(positions(drives) == Targets{0, 0, 0});
  }
}

TEST_CASE("The example brakes when nobody asks it where it is, as when its caller hangs") {
  LinkedDrives drives = drives_of(example());
  make_ready(drives);
  drives.set_targets({6000, 0, 0});
  const SteadyClock clock;
  const double until_s = clock.now_s() + 1.2;
  REQUIRE(test::eventually([&] { return clock.now_s() > until_s; }));
  const DriveStatus status = drives.status()[0];
  CHECK_FALSE(status.moving);
  CHECK(status.position_pulses < 1500);
  CHECK(status.position_certain);
  REQUIRE(status.faults.size() == 1);
  CHECK_THAT(status.faults[0], Contains("came to rest at"));
}

TEST_CASE(
    "Whatever strikes a motion program in a move is named, and positions stay certain by its "
    "word") {
  struct Fault {
    const char* name;
    const char* said;
    bool answers, certain;
  };
  constexpr Fault kFaults[] = {{"late", "has not answered within 300 ms", false, false},
                               {"ends", "ended with status 3", false, false},
                               {"dies", "ended by signal 9", false, false},
                               {"garbage", "answers '", false, false},
                               {"twice", "unasked", false, false},
                               {"endless", "never ends", false, false},
                               {"other number", "answers '", false, false},
                               {"nowhere", "with '1 2 here'; counts", false, false},
                               {"idle", "MOTION must be off", false, false},
                               {"loses", "", true, false},
                               {"alarm", "motor 2 is hot", true, true},
                               {"stalls", "where it was sent to 3000, 3000, 3000", true, true}};
  std::mt19937 random(40);
  std::uniform_int_distribution<int> answer(14, 150);  // in the move, which is asked 200 times
  for (int i = 0; i < test::faults_to_inject(static_cast<int>(std::size(kFaults))); ++i) {
    const Fault& fault = kFaults[static_cast<std::size_t>(i) % std::size(kFaults)];
    const std::string at = std::to_string(answer(random));
    INFO(fault.name << " at answer " << at);
    LinkedDrives drives = drives_of(faulty({fault.name, at}));
    make_ready(drives);
    drives.set_targets({3000, 3000, 3000});
    const test::Struck struck = test::wait_for_fault(drives);
    CHECK(struck.rests);
    CHECK_THAT(struck.said, Contains(fault.said));
    CHECK(struck.certain == fault.certain);
    CHECK(drives.status()[0].answers == fault.answers);
    if (fault.answers) continue;
    CHECK_THROWS_MATCHES(drives.set_targets({0, 0, 0}), DriveError,
                         Refused(Cause::kDevice, fault.said));
    drives.reconnect();
    CHECK(drives.status()[0].answers);
    CHECK_FALSE(drives.status()[0].position_certain);
  }
}

/// Sends this process a signal a thousand times a second that nothing restarts after.
struct Interruptions {
  Interruptions() {
    struct sigaction action {};
    action.sa_handler = [](int) {};
    sigaction(SIGALRM, &action, nullptr);
    set({0, 1000});
  }
  ~Interruptions() { set({0, 0}); }
  Interruptions(const Interruptions&) = delete;
  Interruptions& operator=(const Interruptions&) = delete;
  static void set(const timeval& period) {
    const itimerval every{period, period};
    setitimer(ITIMER_REAL, &every, nullptr);
  }
};

TEST_CASE("A signal while an answer is awaited, as by Ctrl-C, does not make it late") {
  LinkedDrives drives = drives_of(example());
  make_ready(drives);
  const Interruptions interruptions;
  drives.set_targets({1000, -600, 0});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{1000, -600, 0});
  CHECK(drives.status()[0].faults.empty());
}

/// A machine that stops at once, wherever it is.
struct SuddenMachine final : MachineLink {
  explicit SuddenMachine(int& told) : moves_told(told) {}
  void switch_on() override { state.on = true; }
  void go_to(const Pulses& counts, const std::array<DriveLimits, 3>&) override {
    ++moves_told;
    state.moving = true;
    state.counts = counts / 2;
  }
  void stop() override { state.moving = false; }
  void search_home(int, HomeDirection) override {}
  MachineState read() override { return state; }
  const char* starter() const override { return ""; }
  MachineState state;
  int& moves_told;
};

TEST_CASE("A machine that stops sooner than its limits would is not moved on to where these lead") {
  int moves_told = 0;
  LinkedDrives drives("the machine", {kLimits, kLimits, kLimits},
                      [&] { return std::make_unique<SuddenMachine>(moves_told); });
  make_ready(drives);
  drives.set_targets({1000, 0, 0});
  drives.brake_towards({700, 0, 0});
  CHECK(positions(drives) == Targets{500, 0, 0});
  CHECK(drives.status()[0].position_certain);
  CHECK(drives.status()[0].faults.empty());
  CHECK(moves_told == 1);
}

TEST_CASE("A motion program that does not stop is named with what it says") {
  LinkedDrives drives = drives_of(faulty({"runs on"}));
  make_ready(drives);
  drives.set_targets({20000, 0, 0});
  CHECK_THROWS_MATCHES(drives.halt(), DriveError,
                       Refused(Cause::kDevice, "after it was told to stop: it says '"));
  CHECK_THAT(drives.status()[0].faults.front(), Contains(" 0 0 moving 0'"));
}

TEST_CASE("What the machine itself says is wrong stops the arm with these words") {
  SECTION("a lost position") {
    LinkedDrives drives = drives_of(faulty({"loses", "12"}));
    make_ready(drives);
    drives.set_targets({500, 0, 0});
    REQUIRE(all_rest(drives));
    CHECK_FALSE(drives.status()[0].position_certain);
    for (int i = 0; i < 3; ++i) drives.set_position(i, 0);
    CHECK(drives.status()[0].position_certain);
  }
  SECTION("a fault, which switching on again clears") {
    LinkedDrives drives = drives_of(faulty({"alarm", "12"}));
    make_ready(drives);
    drives.set_targets({1500, 0, 0});
    REQUIRE(all_rest(drives));
    CHECK(drives.status()[0].faults == std::vector<std::string>{"motor 2 is hot"});
    CHECK_THROWS_MATCHES(drives.set_targets({0, 0, 0}), DriveError,
                         Refused(Cause::kDevice, "motor 2"));
    drives.energize();
    drives.set_targets({0, 0, 0});
    REQUIRE(all_rest(drives));
    CHECK(positions(drives) == Targets{0, 0, 0});
  }
  SECTION("what it cannot do") {
    LinkedDrives drives = drives_of(example());
    make_ready(drives);
    CHECK_THROWS_MATCHES(drives.start_homing(1, HomeDirection::kReverse), DriveError,
                         Refused(Cause::kDevice, "'home 2 reverse'"));
  }
}

TEST_CASE("A program that does not end with its input is told by signals") {
  const test::TemporaryFolder folder;
  const SteadyClock clock;
  double begun_s = 0.0;
  {
    CommandLink link(faulty({"stays", "1", (folder / "told").string()}));
    begun_s = clock.now_s();
  }
  const double ending_s = clock.now_s() - begun_s;
  CHECK((ending_s >= 2.0 && ending_s < 4.0));  // of which a busy computer takes some
  CHECK(read_file(folder / "told") == "told");
}

TEST_CASE("A program that cannot be started or speaks otherwise is refused") {
  CHECK_THROWS_MATCHES(CommandLink({{"/absent/motion"}, "/", kAnswer_s}), WorkError,
                       Refused(Cause::kMissing, "/absent/motion"));
  CHECK_THROWS_MATCHES(CommandLink({{"sh", "-c", "read line; echo Grbl 1.1h"}, "/", kAnswer_s}),
                       WorkError, Refused(Cause::kDevice, "'Grbl 1.1h'"));
  CHECK_THROWS_MATCHES(
      CommandLink({{"sh", "-c", "read line; printf '1 o\\0k\\n'"}, "/", kAnswer_s}), WorkError,
      Refused(Cause::kDevice, "with '1 o\\x00k'; see doc"));
  CHECK_THROWS_MATCHES(CommandLink({{"true"}, "/", kAnswer_s}), WorkError,
                       Refused(Cause::kDevice, "status 0"));
  CHECK_THROWS_AS(drives_of({{"true"}, "/", kAnswer_s}), DriveError);
}

TEST_CASE("A program that cannot be started is told with its folder and what is amiss") {
  const test::TemporaryFolder folder;
  folder.write("motion.sh", "#!/bin/sh\n");
  CHECK_THROWS_MATCHES(CommandLink({{"./motion.sh"}, folder.path(), kAnswer_s}), WorkError,
                       Refused(Cause::kSystem, "chmod +x"));
  const std::string keys = "kind: command, program: [./absent]";
  test::cell_with_drives(folder, {keys, keys, keys});
  const auto here = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const CellSettings cell = read_cell("cell.yaml");
  std::filesystem::current_path(here);
  const std::vector<Finding> findings = cell.drives[0].kind->examine(cell);
  REQUIRE(findings.size() == 1);
  CHECK_THAT(findings[0].fault, Contains("cannot be started in " + folder.path().string() + ":"));
}

TEST_CASE("The doctor tells the counts of a motion program") {
  const test::TemporaryFolder folder;
  const std::string keys =
      "kind: command, program: [python3, -B, " PLANAR_EXAMPLES "/motion_program.py]";
  const CellSettings cell = read_cell(test::cell_with_drives(folder, {keys, keys, keys}));
  const std::vector<Finding> findings = cell.drives[0].kind->examine(cell);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].fault == "simulated motors, at 0, 0, 0 counts, off");
}

TEST_CASE("A cell file names one motion program for its three joints") {
  const test::TemporaryFolder folder;
  const auto cell_with = [&](const std::string& first, const std::string& others) {
    const std::string kind = "kind: command, answer_ms: ";
    return test::cell_with_drives(folder, {kind + first, kind + others, kind + others});
  };
  CHECK_THROWS_MATCHES(read_cell(cell_with("200, program: []", "200, program: [a]")), InputError,
                       Refused(Cause::kInvalid, "program"));
  CHECK_THROWS_MATCHES(read_cell(cell_with("200, program: [a, b]", "200, program: [a, c]")),
                       InputError, Refused(Cause::kContradiction, "program than drives[0]"));
  CHECK_THROWS_MATCHES(read_cell(cell_with("5, program: [a]", "200, program: [a]")), InputError,
                       Refused(Cause::kInvalid, "answer_ms"));
}

}  // namespace
}  // namespace planar
