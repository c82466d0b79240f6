#include "planar_servo/hardware/links/linuxcnc_link.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <optional>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "planar_servo/base/core/clock.h"
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

constexpr double kCounts = 1000.0;  // to a degree

LinuxcncHost machine() {
  LinuxcncHost host;
  for (std::size_t i = 0; i < 3; ++i)
    host.joints[i] = {static_cast<char>('A' + i),
                      static_cast<int>(i),
                      false,
                      kCounts,
                      {30.0 * kCounts, 300.0 * kCounts}};
  return host;
}

bool is_running() {
  try {
    RshConnection probe(machine());
    return true;
  } catch (const WorkError&) {
    return false;
  }
}

#define REQUIRE_LINUXCNC()                        \
  if (!is_running()) {                            \
    std::puts("skipped: no LinuxCNC is running"); \
    return;                                       \
  }

LinkedDrives drives_of(const LinuxcncHost& host) {
  const DriveLimits rated{30.0 * kCounts, 300.0 * kCounts};
  return {"LinuxCNC",
          {rated, rated, rated},
          [host] { return std::make_unique<LinuxcncLink>(host); },
          kInPosition_counts};
}

void wait(LinkedDrives& drives, double duration_s) {
  const SteadyClock clock;
  const double until_s = clock.now_s() + duration_s;
  REQUIRE(test::eventually([&] { return drives.status()[0].answers && clock.now_s() > until_s; }));
}

/// Another client of the machine.
struct Stranger {
  Stranger() : line(machine()) { line.ask("set enable EMCTOO"); }
  void say(const std::string& words) { CHECK_THAT(line.ask(words), Contains("ACK")); }
  RshConnection line;
};

TEST_CASE("LinuxCNC's joints go where they are sent, and rest there") {
  REQUIRE_LINUXCNC();
  LinkedDrives drives = drives_of(machine());
  CHECK_FALSE(drives.status()[0].position_certain);
  make_ready(drives);
  for (const Targets& targets :
       {Targets{20000, -10000, 5000}, Targets{-3000, 70, 5000}, Targets{0, 0, 0}}) {
    drives.set_targets(targets);
    REQUIRE(all_rest(drives));
    CHECK(positions(drives) == targets);
    CHECK(drives.status()[2].faults.empty());
    CHECK(drives.status()[2].position_certain);
  }
}

TEST_CASE("A halt brakes LinuxCNC at once, and the position stays certain") {
  REQUIRE_LINUXCNC();
  LinkedDrives drives = drives_of(machine());
  make_ready(drives);
  drives.set_targets({60000, 0, 0});
  wait(drives, 0.8);
  const SteadyClock clock;
  const double told_s = clock.now_s();
  const int at = positions(drives)[0];
  drives.halt();
  const Targets rest = positions(drives);
  // At most 30 deg/s for 50 ms, and 0.1 s of braking.
  CHECK(rest[0] - at < 30.0 * kCounts * (0.05 + 0.05));
  CHECK(clock.now_s() - told_s < 0.45);
  CHECK(drives.status()[0].position_certain);
  wait(drives, 0.3);
  CHECK(std::abs(positions(drives)[0] - rest[0]) <= 1);
  drives.set_targets({0, 0, 0});
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == Targets{0, 0, 0});
}

TEST_CASE("A move that follows a halt at once is not stopped by it") {
  REQUIRE_LINUXCNC();
  LinkedDrives drives = drives_of(machine());
  make_ready(drives);
  for (int i = 0; i < 5; ++i) {
    drives.set_targets({60000, 0, 0});
    wait(drives, 0.5);
    drives.halt();
    const Targets near{positions(drives)[0] - 5000, 0, 0};
    drives.set_targets(near);
    REQUIRE(all_rest(drives));
    CHECK(positions(drives) == near);
    CHECK(drives.status()[0].faults.empty());
  }
  drives.set_targets({0, 0, 0});
  REQUIRE(all_rest(drives));
}

/// A process that moves joint A by 60 deg, and tells where it is.
struct MovingProcess {
  MovingProcess() {
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    process = fork();
    if (process == 0) move(ends[1]);
    close(ends[1]);
    line = ends[0];
  }
  ~MovingProcess() {
    kill(process, SIGKILL);
    waitpid(process, nullptr, 0);
    close(line);
  }
  MovingProcess(const MovingProcess&) = delete;
  MovingProcess& operator=(const MovingProcess&) = delete;

  [[noreturn]] static void move(int told) {
    try {
      LinuxcncLink link(machine());
      link.switch_on();
      const DriveLimits limits{30.0 * kCounts, 300.0 * kCounts};
      const int from = link.read().counts[0];
      link.go_to(link.read().counts + Pulses(60000, 0, 0), {limits, limits, limits});
      for (MachineState state = link.read(); state.moving; state = link.read())
        if (write(told, &state.counts[0], sizeof(int)) != sizeof(int) || state.counts[0] < from)
          break;
    } catch (const WorkError&) {
      _exit(1);
    }
    _exit(0);
  }
  int next_count() const {
    int count = 0;
    return read(line, &count, sizeof count) == sizeof count ? count : -1;
  }

  pid_t process{-1};
  int line{-1};
};

// linuxcncrsh mistakes lines that come at once from two connections: nobody else asks meanwhile.
TEST_CASE("A program that dies or hangs in a move leaves LinuxCNC at most 0.2 s of travel") {
  REQUIRE_LINUXCNC();
  const int fate = GENERATE(SIGKILL, SIGSTOP);
  INFO("signal " << fate);
  const int from = LinuxcncLink(machine()).read().counts[0];
  const MovingProcess mover;
  int there = mover.next_count();
  while (there < from + 15000 && there != -1) there = mover.next_count();
  REQUIRE(there >= from + 15000);
  kill(mover.process, fate);
  SteadyClock clock;
  clock.sleep_for_s(1.0);
  const int rest = LinuxcncLink(machine()).read().counts[0];
  CHECK(rest > there);
  // Full speed for 0.2 s, and half of it for the 0.1 s in which it brakes.
  CHECK(rest - there < 30.0 * kCounts * (0.2 + 0.05));
}

TEST_CASE("LinuxCNC's emergency stop ends a move, and the position with it") {
  REQUIRE_LINUXCNC();
  LinkedDrives drives = drives_of(machine());
  make_ready(drives);
  drives.set_targets({60000, 0, 0});
  wait(drives, 0.3);
  Stranger stranger;
  stranger.say("set estop on");
  REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
  CHECK_FALSE(drives.status()[0].position_certain);
  CHECK(drives.status()[0].stopped_by_hand);
  REQUIRE(all_rest(drives));
  CHECK_THROWS_AS(drives.set_targets({0, 0, 0}), DriveError);
  drives.energize();
  CHECK(drives.status()[0].faults.empty());
}

TEST_CASE("A program that is held up is braked, keeps its position and may go on") {
  REQUIRE_LINUXCNC();
  LinkedDrives drives = drives_of(machine());
  make_ready(drives);
  const Targets there{60000, 0, 0};
  drives.set_targets(there);
  wait(drives, 0.5);
  SteadyClock().sleep_for_s(1.0);
  REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
  CHECK_THAT(drives.status()[0].faults.front(),
             Contains("was not asked for long") || Contains("too busy"));
  CHECK(drives.status()[0].position_certain);
  const int at = positions(drives)[0];
  CHECK(at > 0);
  CHECK(at < there[0]);
  drives.energize();
  CHECK(drives.status()[0].faults.empty());
  CHECK(drives.status()[0].position_certain);
  CHECK(std::abs(positions(drives)[0] - at) <= kInPosition_counts);
  drives.set_targets(there);
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == there);
  drives.set_targets({0, 0, 0});
  REQUIRE(all_rest(drives));
}

TEST_CASE("Another client that takes LinuxCNC or moves it is noticed") {
  REQUIRE_LINUXCNC();
  LinkedDrives drives = drives_of(machine());
  make_ready(drives);
  Stranger stranger;
  SECTION("in mid-move") {
    drives.set_targets({60000, 0, 0});
    wait(drives, 0.3);
    stranger.say("set enable EMCTOO");
    REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
    CHECK_THAT(drives.status()[0].faults.front(), Contains("another client"));
    CHECK(drives.status()[0].stopped_by_hand);
    CHECK_FALSE(drives.status()[0].position_certain);
    drives.halt();
  }
  SECTION("at rest") {
    stranger.say("set mode mdi");
    stranger.say("set mdi G91 G1 B2 F600");
    REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
    CHECK_THAT(drives.status()[0].faults.front(), Contains("moved by somebody else"));
    CHECK_FALSE(drives.status()[0].position_certain);
    REQUIRE(all_rest(drives));
    CHECK_THROWS_MATCHES(drives.set_targets({0, 0, 0}), DriveError,
                         Refused(Cause::kDevice, "moved by somebody else"));
    stranger.say("set mdi G90");
  }
}

/// Stands between a program and LinuxCNC, and lets through, drops or ends what they say.
class Wire {
 public:
  enum class State { kWhole, kMute, kCut };

  explicit Wire(LinuxcncHost& host) {
    host.port = test::listening_port(listener_);
    thread_ = std::thread([this] { carry(); });
  }
  ~Wire() {
    state = State::kCut;
    ends_ = true;
    thread_.join();
    close(listener_);
  }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  std::atomic<State> state{State::kWhole};

 private:
  void carry() {
    std::vector<std::pair<int, int>> ways;  // from, to
    while (!ends_) {
      std::vector<pollfd> waiting{{listener_, POLLIN, 0}};
      for (const auto& way : ways) waiting.push_back({way.first, POLLIN, 0});
      constexpr int kPoll_ms = 2;
      poll(waiting.data(), waiting.size(), kPoll_ms);
      if (state == State::kCut) {
        for (const auto& way : ways) shutdown(way.first, SHUT_RDWR);
        continue;
      }
      for (std::size_t i = 1; i < waiting.size(); ++i) {
        char bytes[4096];
        if ((waiting[i].revents & POLLIN) == 0) continue;
        const ssize_t count = ::read(ways[i - 1].first, bytes, sizeof bytes);
        if (count > 0 && state == State::kWhole)
          (void)!send(ways[i - 1].second, bytes, static_cast<std::size_t>(count), MSG_NOSIGNAL);
        if (count == 0) shutdown(ways[i - 1].second, SHUT_WR);
        if (count <= 0) ways[i - 1].first = -1;  // poll() passes over it
      }
      if ((waiting[0].revents & POLLIN) == 0) continue;
      const int near = accept(listener_, nullptr, nullptr), far = socket(AF_INET, SOCK_STREAM, 0);
      sockaddr_in address{};
      address.sin_family = AF_INET;
      address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      address.sin_port = htons(static_cast<std::uint16_t>(machine().port));
      (void)!connect(far, reinterpret_cast<sockaddr*>(&address), sizeof address);
      opened_.insert(opened_.end(), {near, far});
      ways.emplace_back(near, far);
      ways.emplace_back(far, near);
    }
    for (const int end : opened_) close(end);
  }

  int listener_{socket(AF_INET, SOCK_STREAM, 0)};
  std::vector<int> opened_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

TEST_CASE("A line to LinuxCNC that gets lost in a move is asked anew before the machine brakes") {
  REQUIRE_LINUXCNC();
  LinuxcncHost host = machine();
  Wire wire(host);
  LinkedDrives drives = drives_of(host);
  make_ready(drives);
  const Targets there{30000, -10000, 5000};
  drives.set_targets(there);
  wait(drives, 0.3);
  for (int i = 0; i < 5; ++i) {
    wire.state = Wire::State::kMute;
    std::thread mended([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      wire.state = Wire::State::kWhole;
    });
    CHECK(drives.status()[0].answers);
    mended.join();
  }
  REQUIRE(all_rest(drives));
  CHECK(positions(drives) == there);
  CHECK(drives.status()[0].position_certain);
  CHECK(drives.status()[0].faults.empty());
  drives.set_targets({0, 0, 0});
  REQUIRE(all_rest(drives));
}

/// Takes the control and gives an order, until LinuxCNC answers that `what` is so. A line gets lost
/// where another connection's comes at the same moment.
bool brings(RshConnection& stranger, const std::string& order, const std::string& what,
            const char* answer) {
  for (int i = 0; i < 5; ++i) {
    for (const std::string& line : {std::string("set enable EMCTOO"), order}) {
      stranger.send(line);
      stranger.hear(0.5);
    }
    if (stranger.says(what, answer)) return true;
  }
  return false;
}

TEST_CASE(
    "Whatever strikes LinuxCNC in a move is named, and positions are certain where they hold") {
  REQUIRE_LINUXCNC();
  enum Fault { kEstop, kOff, kTaken, kStopped, kCut, kMute, kCount };
  constexpr const char* kNames[] = {"estop", "off", "taken", "stopped", "cut", "mute"};
  constexpr const char* kSaid[] = {"emergency stop",        "LinuxCNC's machine is off",
                                   "another client",        "",
                                   "closed the connection", "does not answer"};
  std::mt19937 random(40);
  std::uniform_real_distribution<double> after_s(0.05, 1.2);
  for (int i = 0; i < test::faults_to_inject(kCount); ++i) {
    const auto fault = static_cast<Fault>(i % kCount);
    const double strikes_s = after_s(random);
    INFO(kNames[fault] << " after " << strikes_s << " s");
    LinuxcncHost host = machine();
    Wire wire(host);
    test::Struck struck;
    {
      LinkedDrives drives = drives_of(host);
      make_ready(drives);
      drives.set_targets({45000, -20000, 10000});
      wait(drives, strikes_s);
      bool has_struck = true;
      std::thread strike([&] {  // while the drives are asked, or else DeadMansHandle brakes
        if (fault == kCut) wire.state = Wire::State::kCut;
        if (fault == kMute) wire.state = Wire::State::kMute;
        if (fault >= kCut) return;
        RshConnection stranger(machine());
        if (fault == kEstop) has_struck = brings(stranger, "set estop on", "estop", "ON");
        if (fault == kOff) has_struck = brings(stranger, "set machine off", "machine", "OFF");
        if (fault == kTaken) has_struck = brings(stranger, "get time", "enable", "ON");
        if (fault == kStopped) has_struck = brings(stranger, "set abort", "enable", "ON");
      });
      struck = test::wait_for_fault(drives);
      strike.join();
      REQUIRE(has_struck);
      CHECK(struck.rests);
      CHECK_THAT(struck.said, Contains(kSaid[fault]));
      if (fault == kStopped)  // seen by the rest, or by who has the control
        CHECK_THAT(struck.said, Contains("came to rest at") || Contains("another client"));
      CHECK(drives.status()[0].answers == (fault < kCut));
      if (fault >= kCut || fault == kEstop || fault == kOff) CHECK_FALSE(struck.certain);
      if (struck.certain) {
        SteadyClock().sleep_for_s(0.1);
        const Pulses there = LinuxcncLink(machine()).read().counts;
        const Pulses zero = there - Pulses(positions(drives).data());
        CHECK(zero.cwiseAbs().maxCoeff() <= 45000);  // within the machine's own frame
      }
    }
    // Back to where the next move has room.
    SteadyClock().sleep_for_s(fault >= kCut ? 2.5 : 0.2);
    LinkedDrives drives = drives_of(machine());
    make_ready(drives);
    const Pulses at = LinuxcncLink(machine()).read().counts;
    drives.set_targets({-at[0], -at[1], -at[2]});
    REQUIRE(all_rest(drives));
  }
}

TEST_CASE("What LinuxCNC's INI says otherwise than the cell is named") {
  REQUIRE_LINUXCNC();
  CHECK_NOTHROW(LinuxcncLink(machine()));
  LinuxcncHost host = machine();
  host.joints[1].number = 4;
  CHECK_THROWS_MATCHES(LinuxcncLink(host), WorkError, Refused(Cause::kContradiction, "[JOINT_4]"));
  host = machine();
  std::swap(host.joints[0].number, host.joints[1].number);
  CHECK_THROWS_MATCHES(LinuxcncLink(host), WorkError,
                       Refused(Cause::kContradiction, "[TRAJ]COORDINATES"));
  host = machine();
  host.joints[0].rated.speed_pulses_s = 90.0 * kCounts;
  CHECK_THROWS_MATCHES(LinuxcncLink(host), WorkError,
                       Refused(Cause::kContradiction, "MAX_VELOCITY is 60"));
  host = machine();
  host.joints[2].has_switch = true;
  CHECK_THROWS_MATCHES(LinuxcncLink(host), WorkError,
                       Refused(Cause::kContradiction, "HOME_SEARCH_VEL is 0"));
  host = machine();
  host.password = "wrong";
  CHECK_THROWS_MATCHES(LinuxcncLink(host), WorkError, Refused(Cause::kDevice, "'HELLO NAK'"));
  host = machine();
  host.port = 1;
  CHECK_THROWS_MATCHES(LinuxcncLink(host), WorkError, Refused(Cause::kDevice, "127.0.0.1:1:"));
}

}  // namespace
}  // namespace planar
