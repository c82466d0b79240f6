#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <fstream>

#include "planar_servo/base/core/error.h"
#include "planar_servo/machine/rehearsal/firmware_board.h"
#include "support/eventually.h"
#include "support/faulty_grbl.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Shafts = EmulatedGrbl::Pulses;
using test::eventually;
using test::Refused;

/// A board with settings beyond Grbl's own, and a program that speaks with it byte by byte.
struct SpokenBoard {
  explicit SpokenBoard(const EmulatedGrbl::Settings& settings = {{120, 500}})
      : board(folder / "port", settings), port(open(board.port().c_str(), O_RDWR | O_NONBLOCK)) {
    REQUIRE(port >= 0);
  }
  ~SpokenBoard() { close(port); }
  SpokenBoard(const SpokenBoard&) = delete;
  SpokenBoard& operator=(const SpokenBoard&) = delete;

  void say(const std::string& text) const {
    REQUIRE(write(port, text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  }
  /// Returns what the board says up to these words, or nothing when they do not come before long.
  std::string until(const std::string& words) {
    std::size_t end = std::string::npos;
    eventually([&] {
      std::array<char, 512> bytes{};
      const ssize_t n = read(port, bytes.data(), bytes.size());
      if (n > 0) heard.append(bytes.data(), static_cast<std::size_t>(n));
      end = heard.find(words);
      return end != std::string::npos;
    });
    if (end == std::string::npos) return "";
    const std::string said = heard.substr(0, end + words.size());
    heard.erase(0, said.size());
    return said;
  }
  bool hears(const std::string& words) { return !until(words).empty(); }
  bool answers(const std::string& line, const std::string& words) {
    say(line + "\n");
    return hears(words + "\r\n");
  }
  /// Returns whether a report says this before long.
  bool is(const std::string& state) {
    return eventually([&] {
      say("?");
      return until(">").find(state) != std::string::npos;
    });
  }

  test::TemporaryFolder folder;
  test::FaultyGrbl board;
  int port;
  std::string heard;
};

TEST_CASE("An emulated board lists its settings, keeps those that it is sent and names faults") {
  SpokenBoard bench;
  CHECK(bench.answers("$$", "$110=500.000"));
  CHECK(bench.answers("", "ok"));
  CHECK(bench.answers("$110=900", "ok"));
  CHECK(bench.answers("$$", "$110=900.000"));
  CHECK(bench.answers("hello", "error:3"));
  CHECK(bench.answers("$J=G53X1", "error:22"));
  CHECK(bench.answers("$J=X1F100", "error:16"));
  CHECK(bench.answers("$H", "error:5"));
}

TEST_CASE("An emulated board turns its motors to where jogs lead, and reports where they stand") {
  SpokenBoard bench;
  CHECK(bench.answers("$J=G53X0.4F500", "ok"));
  CHECK(bench.answers("$J=G53X0.8Z-0.2F500", "ok"));
  CHECK(eventually([&] { return bench.board.shafts() == Shafts(200, 0, -50); }));
  CHECK(bench.is("Idle|MPos:0.800,0.000,-0.200|"));
}

TEST_CASE("An emulated board brakes for a cancelled jog, and reads no line before it rests") {
  SpokenBoard bench(EmulatedGrbl::Settings{{120, 20}});
  CHECK(bench.answers("$J=G53X50F500", "ok"));
  REQUIRE(eventually([&] { return bench.board.shafts().x() > 100; }));
  bench.say("\x85");
  CHECK(bench.answers("$1=255", "ok"));
  const Shafts rest = bench.board.shafts();
  CHECK(rest.x() > 100);
  CHECK(rest.x() < 12500);
  CHECK(bench.is("Idle|"));
  CHECK(bench.board.shafts() == rest);
}

TEST_CASE("An emulated board holds and resumes by single bytes") {
  SpokenBoard bench;
  bench.say("!");
  CHECK(bench.is("Hold:0|"));
  CHECK(bench.answers("$J=G53X1F100", "error:8"));
  bench.say("~");
  CHECK(bench.is("Idle|"));
}

TEST_CASE("An emulated board that hits a limit raises an alarm and moves only once unlocked") {
  SpokenBoard bench({{21, 1}, {120, 500}});
  bench.board.press_limit('Y', true);
  CHECK(bench.hears("ALARM:1"));
  CHECK(bench.is("Alarm|"));
  CHECK(bench.is("|Pn:Y>"));
  CHECK(bench.answers("$J=G53X1F100", "error:9"));
  bench.board.press_limit('Y', false);
  CHECK(bench.answers("$X", "ok"));
  CHECK(bench.answers("$J=G53X0.1F500", "ok"));
}

TEST_CASE("An emulated board finds its home switches, and says when it has none") {
  SpokenBoard bench({{22, 1}, {25, 6000}, {120, 500}});
  bench.say("$H\n");
  CHECK(bench.hears("ALARM:9"));
  CHECK(bench.hears("Grbl 1.1"));
  bench.board.place_switches(Eigen::Vector3d(-1.0, 0.5, 0.0));
  CHECK(bench.answers("$H", "ok"));
  CHECK(bench.board.shafts() == Shafts(-250, 125, 0));
  CHECK(bench.is("Idle|MPos:-1.000,-1.000,-1.000|"));
}

TEST_CASE("An emulated board that is reset on its way forgets where it stands") {
  SpokenBoard bench(EmulatedGrbl::Settings{{22, 1}});
  CHECK(bench.answers("$X", "ok"));
  CHECK(bench.answers("$J=G53X50F500", "ok"));
  REQUIRE(eventually([&] { return bench.board.shafts().x() > 50; }));
  bench.board.press_reset();
  CHECK(bench.hears("Grbl 1.1"));
  CHECK(bench.is("Alarm|MPos:0.000,0.000,0.000|"));
  CHECK(bench.board.shafts().x() > 50);
}

TEST_CASE("A serial port keeps its name when it is plugged in again, and takes no file's place") {
  const test::TemporaryFolder folder;
  PtyPort port(folder / "port");
  port.unplug();
  CHECK_FALSE(std::filesystem::exists(std::filesystem::symlink_status(folder / "port")));
  CHECK(port.read(0.0).empty());
  port.plug_in();
  CHECK(std::filesystem::is_symlink(folder / "port"));
  std::ofstream(folder / "file") << "kept";
  CHECK_THROWS_MATCHES(PtyPort(folder / "file"), InputError, Refused(Cause::kSystem, "/file"));
}

TEST_CASE("What is no firmware is refused as a board") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_MATCHES(FirmwareBoard(folder / "absent", {}, {}, folder / "port"), InputError,
                       Refused(Cause::kMissing, "/absent"));
  CHECK_THROWS_MATCHES(FirmwareBoard("/bin/true", {}, {}, folder / "port"), WorkError,
                       Refused(Cause::kDevice, "status 0"));
}

}  // namespace
}  // namespace planar
