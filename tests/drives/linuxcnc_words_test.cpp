#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cctype>
#include <csignal>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "planar_servo/hardware/links/linuxcnc_link.h"
#include "support/link_bench.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

/// Answers as linuxcncrsh does, for a machine that rests.
class EmulatedRsh {
 public:
  EmulatedRsh() {
    host.port = test::listening_port(listener_);
    for (std::size_t i = 0; i < 3; ++i)
      host.joints[i] = {
          static_cast<char>('A' + i), static_cast<int>(i), false, 1000.0, {30000.0, 300000.0}};
  }
  ~EmulatedRsh() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
    close(listener_);
  }
  EmulatedRsh(const EmulatedRsh&) = delete;
  EmulatedRsh& operator=(const EmulatedRsh&) = delete;

  void begin() {
    thread_ = std::thread([this] { serve(); });
  }
  /// Says this from now on; as "", whole lines before each answer.
  void say(const std::string& what, const std::string& value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    says_[what] = value;
  }
  /// Returns the first line so far that begins with this, or nothing.
  std::string told(const std::string& begin) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const std::string& line : told_)
      if (line.rfind(begin, 0) == 0) return line;
    return "";
  }
  std::ptrdiff_t moves_told() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::count_if(told_.begin(), told_.end(),
                         [](const std::string& line) { return line.rfind("set mdi", 0) == 0; });
  }
  LinkedDrives drives() const {
    const DriveLimits rated = host.joints[0].rated;
    return {"LinuxCNC",
            {rated, rated, rated},
            [this] { return std::make_unique<LinuxcncLink>(host); },
            kInPosition_counts};
  }

  LinuxcncHost host;
  std::atomic<int> mixed_up{0};  ///< as many moves are not understood
  bool homes{true};              ///< joints where they stand, which are at 5 degrees then
  /// So many of the connections, the youngest first, are torn at once.
  std::atomic<std::size_t> torn{0};

 private:
  void serve() {
    std::vector<pollfd> open{{listener_, POLLIN, 0}};
    std::map<int, std::string> heard;
    while (!ends_) {
      constexpr int kPoll_ms = 2;
      poll(open.data(), open.size(), kPoll_ms);
      for (std::size_t i = 1; i < open.size(); ++i) {
        if (open[i].revents == 0) continue;
        char bytes[1024];
        const ssize_t count = ::read(open[i].fd, bytes, sizeof bytes);
        if (count > 0) {
          heard[open[i].fd].append(bytes, static_cast<std::size_t>(count));
          answer(open[i].fd, heard[open[i].fd]);
        } else {
          close(open[i].fd);
          heard.erase(open[i].fd);
          open[i].fd = -1;  // poll() passes over it
        }
      }
      if (open[0].revents != 0) open.push_back({accept(listener_, nullptr, nullptr), POLLIN, 0});
      for (std::size_t left = torn; left > 0; torn = --left) {
        const linger at_once{1, 0};
        setsockopt(open.back().fd, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
        close(open.back().fd);
        open.pop_back();
      }
    }
    for (std::size_t i = 1; i < open.size(); ++i)
      if (open[i].fd >= 0) close(open[i].fd);
  }

  void answer(int line, std::string& heard) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (std::size_t end = heard.find("\r\n"); end != heard.npos; end = heard.find("\r\n")) {
      const std::string words = answer_to(heard.substr(0, end));
      heard.erase(0, end + 2);
      (void)!send(line, words.data(), words.size(), MSG_NOSIGNAL);
    }
  }

  std::string answer_to(const std::string& line) {
    told_.push_back(line);
    const std::string what = line.substr(line.find(' ') + 1);
    std::string name = what.substr(0, what.find(' '));
    if (line.rfind("hello", 0) == 0) return "HELLO ACK EMCNETSVR 1.1\r\n";
    if (line == "set echo off") return "";
    if (line.rfind("get", 0) == 0) return says_[""] + name + " " + says_[what] + "\r\n";
    if (name == "mdi" && mixed_up > 0) {
      --mixed_up;
      return "SET NAK\r\n";
    }
    if (name == "home" && homes) {
      says_["joint_homed " + what.substr(what.size() - 1)] = "0 YES";
      says_["joint_pos"] = "5 5 5";
    }
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::toupper(letter)); });
    return "SET " + name + " ACK\r\n";
  }

  int listener_{socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  std::mutex mutex_;
  std::map<std::string, std::string> says_{{"inifile", "elsewhere.ini"},
                                           {"joint_pos", "0 0 0"},
                                           {"estop", "OFF"},
                                           {"machine", "ON"},
                                           {"mode", "MDI"},
                                           {"enable", "ON"},
                                           {"joint_limit", "OK OK OK"},
                                           {"joint_fault", "OK OK OK"},
                                           {"program_status", "IDLE"},
                                           {"joint_homed 0", "0 YES"},
                                           {"joint_homed 1", "1 YES"},
                                           {"joint_homed 2", "2 YES"}};
  std::vector<std::string> told_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

bool rests(LinkedDrives& drives) {
  return test::all_rest(drives) && drives.status()[0].answers;
}

TEST_CASE("Joints that LinuxCNC homes where they stand have lost their positions by that") {
  EmulatedRsh rsh;
  SECTION("which is seen when they are switched on again") {
    rsh.begin();
    LinkedDrives drives = rsh.drives();
    test::make_ready(drives);
    drives.energize();
    CHECK(drives.status()[0].position_certain);
    rsh.say("joint_homed 1", "1 NO");
    drives.energize();
    REQUIRE(rests(drives));
    CHECK(rsh.told("set home") == "set home 1");
    for (const DriveStatus& drive : drives.status()) {
      CHECK_FALSE(drive.position_certain);
      CHECK(drive.faults.empty());
    }
  }
  SECTION("and those that it does not home are not switched on") {
    rsh.homes = false;
    rsh.begin();
    rsh.say("joint_homed 1", "1 NO");
    LinkedDrives drives = rsh.drives();
    CHECK_THROWS_MATCHES(drives.energize(), DriveError, Refused(Cause::kDevice, "joint 1"));
  }
}

TEST_CASE("LinuxCNC's late answers to other lines are passed over") {
  EmulatedRsh rsh;
  rsh.begin();
  RshConnection connection(rsh.host);
  rsh.say("", "SET ENABLE ACK\r\nSET ABORT ACK\r\n");
  CHECK(connection.get("enable") == "ON");
  CHECK(connection.get("estop") == "OFF");
}

TEST_CASE("A move of LinuxCNC says every mode that another client may have set") {
  EmulatedRsh rsh;
  rsh.begin();
  LinkedDrives drives = rsh.drives();
  test::make_ready(drives);
  drives.set_targets({2000, 0, -1000});
  REQUIRE(test::eventually([&] { return !rsh.told("set mdi").empty(); }));
  CHECK_THAT(rsh.told("set mdi"), Catch::StartsWith("set mdi G53 G61 G90 G94 G1 A2.000000 "
                                                    "B0.000000 C-1.000000 F"));
}

TEST_CASE("A move that linuxcncrsh mixed up with another line is sent again, at most twice") {
  for (const int times : {1, 5}) {
    EmulatedRsh rsh;
    rsh.mixed_up = times;
    rsh.begin();
    LinuxcncLink link(rsh.host);
    link.switch_on();
    link.go_to({100, 100, 100},
               {rsh.host.joints[0].rated, rsh.host.joints[1].rated, rsh.host.joints[2].rated});
    const std::vector<std::string> faults = [&] {
      MachineState state = link.read();
      for (int i = 0; i < 50 && state.faults.empty(); ++i) state = link.read();
      return state.faults;
    }();
    CHECK(rsh.moves_told() == std::min(times + 1, 3));
    CHECK(faults.empty() == (times == 1));
  }
}

TEST_CASE("A LinuxCNC that does not begin a move is told so, and of no map") {
  EmulatedRsh rsh;
  rsh.begin();
  LinkedDrives drives = rsh.drives();
  test::make_ready(drives);
  drives.set_targets({2000, 0, 0});
  REQUIRE(test::eventually([&] { return !drives.status()[0].faults.empty(); }));
  CHECK_THAT(drives.status()[0].faults.front(),
             Catch::StartsWith("it did not begin: look at LinuxCNC's messages, limits"));
}

TEST_CASE("A LinuxCNC that does not come to rest is named with what says so") {
  EmulatedRsh rsh;
  rsh.begin();
  LinkedDrives drives = rsh.drives();
  drives.energize();
  rsh.say("program_status", "RUNNING");
  CHECK_THROWS_MATCHES(
      drives.halt(), DriveError,
      Refused(Cause::kDevice, "after it was told to stop: its program_status is RUNNING"));
}

TEST_CASE("A joint that would move as LinuxCNC homes it where it stands is refused") {
  EmulatedRsh rsh;
  rsh.begin();
  const test::TemporaryFolder folder;
  const auto open_with = [&](const std::string& keys) {
    std::string ini;
    for (const char* joint : {"0", "1", "2"})
      ini += std::string("[JOINT_") + joint +
             "]\nTYPE = ANGULAR\nMAX_VELOCITY = 30\nMAX_ACCELERATION = 300\n";
    rsh.say("inifile", folder.write("machine.ini", ini + keys).string());
    const LinuxcncLink link(rsh.host);
  };
  CHECK_NOTHROW(open_with(""));
  CHECK_THROWS_MATCHES(open_with("HOME = 5\n"), WorkError,
                       Refused(Cause::kContradiction, "[JOINT_2]HOME is 5 and HOME_OFFSET 0"));
  CHECK_NOTHROW(open_with("HOME = 5\nHOME_OFFSET = 5\n"));
  CHECK_NOTHROW(open_with("HOME = 5\nHOME_ABSOLUTE_ENCODER = 2\n"));
  CHECK_THROWS_MATCHES(open_with("HOME_LATCH_VEL = 1\n"), WorkError,
                       Refused(Cause::kContradiction, "[JOINT_2]HOME_LATCH_VEL is 1"));
}

TEST_CASE("A move beyond the limits of LinuxCNC's own INI is refused, and nothing is lost") {
  EmulatedRsh rsh;
  rsh.begin();
  const test::TemporaryFolder folder;
  std::string ini = "[AXIS_B]\nMAX_LIMIT = 1.5\n";
  for (const char* joint : {"0", "1", "2"})
    ini += std::string("[JOINT_") + joint +
           "]\nTYPE = ANGULAR\nMAX_VELOCITY = 30\nMAX_ACCELERATION = 300\nMIN_LIMIT = -3\n";
  rsh.say("inifile", folder.write("machine.ini", ini).string());
  LinkedDrives drives = rsh.drives();
  test::make_ready(drives);
  CHECK_THROWS_MATCHES(drives.set_targets({0, 2000, 0}), DriveError,
                       Refused(Cause::kUnreachable, "from -3 to 1.5 deg"));
  CHECK_THROWS_MATCHES(drives.set_targets({0, 0, -3001}), DriveError,
                       Refused(Cause::kUnreachable, "-3.001 deg"));
  CHECK(rsh.told("set mdi").empty());
  CHECK(rests(drives));
  for (const DriveStatus& drive : drives.status()) CHECK(drive.position_certain);
  CHECK_NOTHROW(drives.set_targets({2000, 1500, -3000}));
}

TEST_CASE("An order to stop goes by another connection where one is torn, or is not given") {
  EmulatedRsh rsh;
  rsh.begin();
  LinuxcncLink link(rsh.host);  // which reads, moves and stops by a connection each
  const auto tear = [&](std::size_t connections) {
    rsh.torn = connections;
    REQUIRE(test::eventually([&] { return rsh.torn == 0; }));
  };
  tear(1);
  link.stop();
  CHECK(test::eventually([&] { return !rsh.told("set abort").empty(); }));
  tear(1);
  CHECK_THROWS_MATCHES(link.stop(), WorkError, Refused(Cause::kDevice, "connection"));
}

TEST_CASE("A move is stopped by another connection once that for stops is torn") {
  EmulatedRsh rsh;
  rsh.begin();
  LinuxcncLink link(rsh.host);
  link.switch_on();
  rsh.torn = 1;
  REQUIRE(test::eventually([&] { return rsh.torn == 0; }));
  const DriveLimits rated = rsh.host.joints[0].rated;
  link.go_to({100, 100, 100}, {rated, rated, rated});
  CHECK_THROWS_MATCHES(link.read(), WorkError, Refused(Cause::kDevice, "closed the connection"));
  CHECK(test::eventually([&] { return !rsh.told("set abort").empty(); }));
}

/// Ends the one process that this thread has begun.
void kill_child() {
  std::ifstream children("/proc/thread-self/children");
  pid_t child = 0;
  REQUIRE(children >> child);
  kill(child, SIGKILL);
  siginfo_t ended;
  REQUIRE(waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT) == 0);
}

TEST_CASE("Nothing moves by LinuxCNC once the process that would brake it has ended") {
  EmulatedRsh rsh;
  rsh.begin();
  LinkedDrives drives = rsh.drives();
  test::make_ready(drives);
  SECTION("before a move") {
    kill_child();
    CHECK_THROWS_MATCHES(drives.set_targets({2000, 0, 0}), DriveError,
                         Refused(Cause::kSystem, "has ended"));
    CHECK(rsh.told("set mdi").empty());
  }
  SECTION("nor does a move go on") {
    drives.set_targets({2000, 0, 0});
    rsh.say("program_status", "RUNNING");
    REQUIRE(drives.status()[0].moving);
    kill_child();
    CHECK_THAT(drives.status()[0].faults.front(), Catch::Contains("has ended"));
    CHECK(test::eventually([&] { return !rsh.told("set abort").empty(); }));
  }
  CHECK_FALSE(drives.status()[0].position_certain);
}

/// A program that moves until it is suspended.
[[noreturn]] void move_on(const LinuxcncHost& host) {
  setpgid(0, 0);
  try {
    RshConnection line(host), stopper(host);
    DeadMansHandle handle(stopper, "set abort\r\n");
    handle.hold(true);
    line.ask("set moving on");
    for (;; std::this_thread::sleep_for(std::chrono::milliseconds(5))) handle.hold(true);
  } catch (const WorkError&) {
    _exit(1);
  }
}

TEST_CASE("A program that Ctrl-Z suspends in a move has LinuxCNC brake") {
  EmulatedRsh rsh;
  const pid_t program = fork();  // before there is a thread
  REQUIRE(program >= 0);
  if (program == 0) move_on(rsh.host);
  rsh.begin();
  CHECK(test::eventually([&] { return !rsh.told("set moving").empty(); }));
  kill(-program, SIGSTOP);  // the whole group, as a terminal does
  CHECK(test::eventually([&] { return !rsh.told("set abort").empty(); }));
  kill(program, SIGKILL);
  waitpid(program, nullptr, 0);
}

}  // namespace
}  // namespace planar
